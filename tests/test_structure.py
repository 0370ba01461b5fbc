"""The order of the imports is the order of the data, and what is built is what is installed."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

ORDER = (
    ("errors", "limits", "progress", "threads", "compiling"),
    ("settings", "stopwatch"),
    ("config", "clip", "files"),
    ("events", "curves", "strokes"),
    ("stroke_shape", "stroke_life", "brushwork"),
    ("life_edits",),
    ("decode_frame",),
    ("decode_holds", "decode_images", "decode_video"),
    ("decode",),
    ("page", "palette", "fades"),
    ("ink",),
    ("render", "losses", "perceptual"),
    ("visibility",),
    ("parameters",),
    ("adam", "gauss_newton", "material"),
    ("optimise", "temporal", "evidence", "picture"),
    ("initialise", "reference", "corrected_shapes"),
    ("propagate", "link"),
    ("vote",),
    ("drawing_terms", "edits", "opacity", "seen_ends"),
    ("fit",),
    ("start",),
    ("true_strokes",),
    ("metrics", "point_metrics"),
    ("clip_metrics",),
    ("track_archive", "stroke_track"),
    ("track_set",),
    ("track_edits", "track_layouts"),
    ("tracks",),
    ("brush",),
    ("write", "quality"),
    ("correction",),
    ("export",),
    ("doctor", "run_folder"),
    ("run", "finished_run"),
    ("bench", "painting"),
    ("options", "console"),
    ("cli_bench", "cli_brush"),
    ("cli",),
)
"""Modules and packages of videovec; each may import those of its own line and of the lines above."""

LEVEL = {name: level for level, names in enumerate(ORDER) for name in names}


def _modules() -> Iterator[tuple[str, Path]]:
    """The top-level part of videovec that each file belongs to, and the file; of all parts that have their place."""
    for path in sorted((ROOT / "videovec").rglob("*.py")):
        part = path.relative_to(ROOT / "videovec").parts[0].removesuffix(".py")
        if part in LEVEL:
            yield part, path


def _imports(source: str) -> Iterator[str]:
    """Every module that a text imports, wherever it does."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            if node.module == "videovec":
                yield from (f"videovec.{alias.name}" for alias in node.names)


def _against_order(part: str, source: str) -> list[str]:
    """Imports of later parts, of parts without a place, and of pipelines."""
    return [name for name in _imports(source) if "pipelines" in name.split(".") or _level(name) > LEVEL[part]]


def _level(name: str) -> int:
    """How late in the order a module stands; -1 for one that is not of videovec."""
    top, _, rest = name.partition(".")
    return LEVEL.get(rest.partition(".")[0], -1) if top == "videovec" else -1


def test_every_module_has_its_place_in_the_order() -> None:
    parts = {path.stem for path in (ROOT / "videovec").glob("[!_.]*") if path.suffix in {"", ".py"}}
    assert parts - {"weights"} <= set(LEVEL)


@pytest.mark.parametrize(("part", "path"), [pytest.param(*pair, id=str(pair[1].name)) for pair in _modules()])
def test_a_module_imports_only_what_comes_before_it(part: str, path: Path) -> None:
    assert _against_order(part, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "source",
    [
        "from videovec.run import run",
        "import videovec.cli",
        "from videovec import fit",
        "from videovec.pipelines import solid",
        "import pipelines.solid",
        "def f():\n    from videovec.export import export",
    ],
)
def test_the_check_of_the_order_can_fail(source: str) -> None:
    assert _against_order("curves", source)


def _module_graph(root: Path, package: str) -> dict[str, set[str]]:
    """What every module below a package imports of it; not the package itself, which names its objects lazily."""
    paths = {".".join((package, *path.relative_to(root).with_suffix("").parts)): path for path in root.rglob("*.py")}
    modules = {name.removesuffix(".__init__"): path for name, path in paths.items()}
    del modules[package]
    graph = {}
    for name, path in modules.items():
        found = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                found |= (inner & modules.keys()) or {node.module}
            elif isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
        graph[name] = found & modules.keys() - {name}
    return graph


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = _module_graph(ROOT / "videovec", "videovec")
    assert len(graph) > 100
    TopologicalSorter(graph).prepare()


def test_the_check_for_circles_can_fail(tmp_path: Path) -> None:
    (tmp_path / "__init__.py").touch()
    (tmp_path / "one.py").write_text("from pack import two\n", encoding="utf-8")
    (tmp_path / "two.py").write_text("def f():\n    from pack.one import g\n", encoding="utf-8")
    with pytest.raises(CycleError):
        TopologicalSorter(_module_graph(tmp_path, "pack")).prepare()


def test_a_pipeline_reads_no_files_and_parses_no_arguments() -> None:
    for path in (ROOT / "pipelines").glob("[!_]*.py"):
        source = path.read_text(encoding="utf-8")
        assert not {"pathlib", "argparse", "typer", "os", "io"} & {name.partition(".")[0] for name in _imports(source)}
        assert "run" in [node.name for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)], path.name


def test_every_package_is_built_into_the_wheel() -> None:
    told = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    folders = [path.parent.relative_to(ROOT) for path in (ROOT / "videovec").rglob("__init__.py")]
    packages = {".".join(folder.parts) for folder in folders}
    assert set(told) == packages | {"videovec.pipelines", "videovec.configs"}
    for path in (ROOT / "videovec").rglob("*.py"):
        assert (path.parent / "__init__.py").exists(), f"{path} is in a folder that is no package"

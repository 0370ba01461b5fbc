"""What ``import videovec`` gives, and that it gives it quickly."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

import videovec
from videovec.cli import app

PUBLIC = [
    "Clip",
    "Config",
    "ConfigError",
    "Event",
    "EventKind",
    "FitError",
    "Ink",
    "InputError",
    "OutputError",
    "StrokeTracks",
    "Strokes",
    "Timeline",
    "UserError",
    "VideovecError",
    "configure",
    "correct",
    "decode",
    "export",
    "extract_ink",
    "fit",
    "initialise",
    "propagate",
    "read_reference",
    "render_strokes",
    "run",
    "track",
]


def _in_fresh_python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout


def test_the_public_names_are_these_and_no_others() -> None:
    assert videovec.__all__ == PUBLIC
    assert dir(videovec) == sorted([*PUBLIC, "__version__"])


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_documented_and_knows_its_home(name: str) -> None:
    thing = getattr(videovec, name)
    assert thing.__doc__
    assert thing.__module__.startswith("videovec.")
    assert name in sys.modules[thing.__module__].__all__


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse(Path(videovec.__file__ or "").read_text(encoding="utf-8"))
    guarded = [node for node in tree.body if isinstance(node, ast.If)]
    seen = [alias.name for node in ast.walk(guarded[0]) if isinstance(node, ast.ImportFrom) for alias in node.names]
    assert sorted(seen) == sorted(PUBLIC)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'vectorise'"):
        videovec.vectorise  # type: ignore[attr-defined]  # noqa: B018


def test_importing_videovec_or_its_command_line_loads_nothing_heavy() -> None:
    code = "import videovec, videovec.cli, sys, json; print(json.dumps(sorted(sys.modules)))"
    loaded = set(json.loads(_in_fresh_python(code)))
    assert not loaded & {"torch", "numba", "numpy", "cv2", "av", "scipy", "kornia", "imageio"}


def test_importing_videovec_takes_less_than_a_fifth_of_a_second() -> None:
    code = "import time; start = time.process_time(); import videovec; print(time.process_time() - start)"
    assert min(float(_in_fresh_python(code)) for _ in range(3)) < 0.2


def test_the_python_of_the_readme_names_what_exists() -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    code = readme.partition("```python\n")[2].partition("```")[0]
    asked = {node.attr for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Attribute)}
    known = {*dir(videovec), *dir(videovec.StrokeTracks), "id", "life"}
    assert asked <= known


def test_the_commands_of_the_readme_exist() -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    lines = [line for line in readme.splitlines() if line.startswith("videovec ")]
    assert {line.split()[1] for line in lines} <= set(get_command(app).commands)  # type: ignore[attr-defined]
    assert len(lines) > 4

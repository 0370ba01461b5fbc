"""What draws, why, with how many threads, and where compiled code is kept."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from videovec.compiling import cache_folder, compiled
from videovec.gauss_newton import _factorise
from videovec.render import Backend, describe_backend, prepare_backend, resolve_backend
from videovec.render import backend as backend_module
from videovec.settings import RenderSettings
from videovec.threads import over_ranges, thread_count


class Listener:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def stage(self, name: str, total: int) -> None:
        raise AssertionError("compiling is no stage")

    def advance(self, count: int = 1) -> None:
        raise AssertionError("compiling has no steps")

    def note(self, text: str) -> None:
        self.notes.append(text)


def test_the_cpu_is_numba_s_and_other_devices_are_torch_s(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert resolve_backend(RenderSettings()) == Backend("numba", torch.device("cpu"))
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert resolve_backend(RenderSettings()) == Backend("torch", torch.device("cuda"))
    assert resolve_backend(RenderSettings(backend="numba")) == Backend("numba", torch.device("cpu"))


def test_the_report_says_what_is_chosen_and_where_code_is_kept() -> None:
    report = describe_backend(RenderSettings(backend="torch", device="cpu"))
    assert report.backend == Backend("torch", torch.device("cpu"))
    assert report.threads == thread_count()
    assert report.cuda
    assert report.versions[0] == torch.__version__


def test_a_first_run_says_that_it_compiles_and_a_later_one_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    listener, numba = Listener(), Backend("numba", torch.device("cpu"))
    monkeypatch.setattr("videovec.compiling.is_compiled", lambda package: False)
    prepare_backend(numba, listener)
    assert len(listener.notes) == 1
    assert "compiling" in listener.notes[0]
    monkeypatch.setattr("videovec.compiling.is_compiled", lambda package: True)
    prepare_backend(numba, listener)
    prepare_backend(Backend("torch", torch.device("cpu")), listener)
    assert len(listener.notes) == 1
    assert Path(backend_module.__file__).parent.name == "render"


@pytest.fixture
def fresh_cache() -> Iterator[None]:
    cache_folder.cache_clear()
    yield
    cache_folder.cache_clear()


@pytest.mark.usefixtures("fresh_cache")
def test_a_cache_that_cannot_be_written_is_done_without(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(blocked))
    assert cache_folder(tmp_path) is None

    @compiled()
    def twice(x: float) -> float:
        return x + x

    assert twice(2.5) == 5


@pytest.mark.usefixtures("fresh_cache")
def test_code_that_changed_has_another_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    source = tmp_path / "kernels.py"
    source.write_text("a = 1")
    before = cache_folder(tmp_path)
    cache_folder.cache_clear()
    source.write_text("a = 2")
    assert before is not None
    assert cache_folder(tmp_path) not in (None, before)


@pytest.mark.usefixtures("fresh_cache")
def test_machine_code_holds_no_copy_of_a_called_function_that_another_s_could_stand_in_for() -> None:
    factorise = compiled()(cast(Any, _factorise).py_func)

    @compiled()
    def factorise_all(bands: NDArray[np.float64], count: int) -> None:
        for n in range(count):
            factorise(bands[n])
        factorise(bands[-1])

    factorise_all(np.ones((2, 12, 10)), 1)
    (code,) = cast(Any, factorise_all).inspect_asm().values()
    functions = [line for line in code.splitlines() if line.lstrip().startswith(".weak") and "factorise" in line]
    assert "factorise_all" in code
    assert not functions


@pytest.mark.parametrize("threads", ["1", "3", "16"])
@pytest.mark.parametrize("count", [0, 1, 7, 100])
def test_ranges_make_up_the_whole_once(count: int, threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIDEOVEC_THREADS", threads)
    seen: list[int] = []
    lock = threading.Lock()

    def work(part: tuple[int, int]) -> None:
        with lock:
            seen.extend(range(*part))

    over_ranges(work, count)
    assert sorted(seen) == list(range(count))


def test_what_goes_wrong_in_a_thread_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIDEOVEC_THREADS", "2")

    def work(part: tuple[int, int]) -> None:
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        over_ranges(work, 10)

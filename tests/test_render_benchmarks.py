"""The benchmarks of the renderer run, tiny, so that they cannot rot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.mark.parametrize(
    ("script", "heading"),
    [("render_speed.py", "## Memory"), ("render_fit.py", "random strokes")],
)
def test_a_benchmark_runs_and_writes_its_table(script: str, heading: str, tmp_path: Path) -> None:
    out = tmp_path / "table.md"
    command = [sys.executable, str(BENCHMARKS / script), "--tiny", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    table = out.read_text(encoding="utf-8")
    assert heading in table
    assert table.count("|---|") >= 2

"""The benchmark of edits runs, on one small drawing, so that it cannot rot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "edits.py"


def test_the_benchmark_of_edits_writes_both_curves(tmp_path: Path) -> None:
    page = np.full((96, 96), 255, np.uint8)
    cv2.ellipse(page, (48, 48), (30, 20), 20.0, 0.0, 250.0, (0,), 3, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "drawing.png"), page)
    out = tmp_path / "edits.md"
    command = [sys.executable, str(SCRIPT), str(tmp_path / "drawing.png"), "--out", str(out)]
    command += ["--prices", "0.005", "--tolerances", "0.35"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = [line for line in out.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    assert [row.split("|")[1].strip() for row in rows][1:3] == ["price 0.005", "no edits, tolerance 0.35"]
    assert out.with_suffix(".png").exists()

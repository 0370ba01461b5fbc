"""The benchmark of noisy stills runs, on one small drawing, so that it cannot rot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "stills_noise.py"


def test_the_benchmark_of_noise_has_a_row_for_every_disturbance(tmp_path: Path) -> None:
    page = np.full((96, 96), 255, np.uint8)
    cv2.ellipse(page, (48, 48), (30, 20), 20.0, 0.0, 250.0, (0,), 3, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "w3_96.png"), page)
    out = tmp_path / "noise.md"
    command = [sys.executable, str(SCRIPT), str(tmp_path / "w3_96.png"), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = [line.split("|")[1:3] for line in out.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    assert [int(count) for _, count in rows[1:]] == [1] * 6

"""Benchmarks against known strokes and against other tracers."""

from __future__ import annotations

from videovec.bench.drawings import Still, read_stills, textured_stills
from videovec.bench.peers import TRACERS
from videovec.bench.report import PROTOCOL, picture_file, scores_to_csv, scores_to_table, sheet
from videovec.bench.stills import Result, StillScore, bench_stills

__all__ = [
    "PROTOCOL",
    "TRACERS",
    "Result",
    "Still",
    "StillScore",
    "bench_stills",
    "picture_file",
    "read_stills",
    "scores_to_csv",
    "scores_to_table",
    "sheet",
    "textured_stills",
]

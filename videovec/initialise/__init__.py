"""From one drawing to strokes: skeleton, graph, junctions, centre lines, splines."""

from __future__ import annotations

from videovec.initialise.tracer import Junction, Traced, initialise, trace

__all__ = ["Junction", "Traced", "initialise", "trace"]

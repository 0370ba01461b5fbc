"""From drawing to drawing: strokes of one drawing become strokes with lives over the whole clip."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from videovec.errors import FitError
from videovec.events import Event
from videovec.ink import Ink
from videovec.progress import Progress, Silent
from videovec.propagate.nodes import bases_of, gather
from videovec.propagate.record import bind, open_lives
from videovec.propagate.register import register, source_of
from videovec.propagate.target import make_target
from videovec.settings import PropagateSettings
from videovec.strokes import Strokes

__all__ = ["Propagated", "Trace", "propagate"]

Trace = Callable[[Ink, int], Strokes]
"""Traces strokes on the ink of one drawing."""


@dataclass(frozen=True, slots=True, eq=False)
class Propagated:
    """Strokes over all drawings.

    Args:
        strokes: S strokes with their lives.
        events: Births, deaths and other turns, by drawing.
        confidence: How well each row's ink supports it, in [0, 1]. [R]
    """

    strokes: Strokes
    events: tuple[Event, ...]
    confidence: NDArray[np.float64]


def propagate(
    ink: Ink, strokes: Strokes, settings: PropagateSettings, trace: Trace, progress: Progress | None = None
) -> Propagated:
    """Carry strokes from the drawing on which they are known to all drawings.

    Args:
        ink: D drawings.
        strokes: Strokes that live on one drawing alone.
        settings: How.
        trace: Traces ink that no stroke explains; see `initialise`.
        progress: Told of every drawing.

    Returns:
        The strokes with their lives, what happened to them, and how sure that is.

    Raises:
        FitError: The strokes live on more than one drawing.
    """
    progress = progress or Silent()
    progress.stage("propagate", ink.drawing_count - 1)
    lives = open_lives(strokes)
    if not lives:
        return Propagated(strokes, (), np.zeros(0))
    seed = lives[0].first
    if any(life.first != seed or life.last != seed for life in lives):
        raise FitError("propagate needs strokes of one drawing")
    scale = min(1.0, settings.working_size / max(ink.size))
    nodes = gather(bases_of(strokes, settings.node_spacing / scale))
    for drawings in (range(seed + 1, ink.drawing_count), range(seed - 1, -1, -1)):
        points, previous = strokes.points, make_target(ink.coverage[seed], settings.working_size)
        for drawing in drawings:
            target = make_target(ink.coverage[drawing], settings.working_size)
            source = source_of(nodes, target.scale * nodes.positions(points), previous)
            positions = register(source, target, source.rest)
            points = nodes.moved(points, positions / target.scale)
            step = -1 if drawing < seed else 1
            for s, life in enumerate(lives):
                row = life.rows[drawing - step]
                part = slice(*strokes.layout.row_points[[s, s + 1]])
                life.rows[drawing] = replace(row, points=points[part])
            previous = target
            progress.advance()
    carried, confidence = bind(lives)
    return Propagated(carried, (), confidence)

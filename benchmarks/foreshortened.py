"""A movie of our own whose figures are foreshortened: what turns on edge, what opens, and a figure that walks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from samples.scene import Drawing, Fill, Line, Movie, ellipse, place, polygon, spline

__all__ = ["foreshortened_movie"]

Floats = NDArray[np.float64]

SIDE = 512
BLACK = (20, 20, 20)
DISC_WIDTH, DOOR_WIDTH, BODY_WIDTH = 8.0, 6.0, 7.0


def foreshortened_movie(count: int = 24) -> Movie:
    """Two discs turn on edge and on, at two speeds; a door opens and closes; a figure walks on the spot.

    Args:
        count: Drawings.
    """
    drawings: list[Drawing] = []
    for d in range(count):
        t = d / (count - 1)
        drawings.append(
            (
                *_disc("coin", (125, 95), (80, 80), math.pi * t),
                *_disc("plate", (385, 105), (80, 60), 0.3 + 1.3 * math.pi * t),
                *_door((300, 225), (115, 220), 75 * math.sin(math.pi * t)),
                *_walker((135, 290), 2 * math.pi * 1.5 * t),
            )
        )
    return Movie.on_ones("foreshortened", (SIDE, SIDE), drawings)


def _disc(name: str, center: tuple[float, float], radius: tuple[float, float], turn: float) -> Drawing:
    """A disc that turns about its upright axis: its edge, a ring and a mark on its face; seen from behind no mark."""
    squeeze = math.cos(turn)
    lines: list[Line | Fill] = [
        Line(f"{name} edge", ellipse((0, 0), radius), DISC_WIDTH, BLACK, True),
        Line(f"{name} ring", ellipse((0, 0), (0.62 * radius[0], 0.62 * radius[1])), DISC_WIDTH, BLACK, True),
    ]
    if squeeze > 0.15:
        mark = spline([(-0.1, -0.3), (0.15, -0.1), (-0.15, 0.1), (0.1, 0.3)]) * radius
        lines.append(Line(f"{name} mark", mark, DISC_WIDTH, BLACK))
    return place(place(lines, scale=(squeeze, 1.0)), center)


def _door(corner: tuple[float, float], size: tuple[float, float], degrees: float) -> Drawing:
    """A door on its left hinge, in perspective, with a panel and a knob, before its frame."""
    angle, (w, h) = math.radians(degrees), size

    def seen(points: Floats) -> Floats:
        x, y = points.T * np.array([[w], [h]])
        away = 1.0 - 0.35 * x * math.sin(angle) / w
        return np.stack([corner[0] + x * math.cos(angle) / away, corner[1] + h / 2 + (y - h / 2) / away], axis=1)

    outline = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)])
    panel = np.array([(0.2, 0.12), (0.8, 0.12), (0.8, 0.5), (0.2, 0.5), (0.2, 0.12)])
    knob = np.array([(0.7, 0.6), (0.88, 0.6)])
    return (
        Line("door frame", polygon([(272, 492), (272, 203), (472, 203), (472, 492)]), DOOR_WIDTH, BLACK),
        Fill(polygon(seen(outline))),
        Line("door", polygon(seen(outline)), DOOR_WIDTH, BLACK, True),
        Line("door panel", polygon(seen(panel)), DOOR_WIDTH, BLACK, True),
        Line("door knob", polygon(seen(knob)), DOOR_WIDTH, BLACK),
    )


def _walker(hip: tuple[float, float], phase: float) -> Drawing:
    """A figure from its side: far arm and leg, trunk and head, near leg and arm; every limb is one bent line."""
    x, y = hip[0], hip[1] + 70 - 5 * math.cos(2 * phase)
    shoulder = (x + 4, y - 85)

    def limb(name: str, root: tuple[float, float], upper: float, bend: float, lengths: tuple[float, float]) -> Line:
        knee = (root[0] + lengths[0] * math.sin(upper), root[1] + lengths[0] * math.cos(upper))
        lower = upper + bend
        foot = (knee[0] + lengths[1] * math.sin(lower), knee[1] + lengths[1] * math.cos(lower))
        return Line(name, polygon([root, knee, foot]), BODY_WIDTH, BLACK)

    def leg(name: str, at: float) -> Line:
        return limb(name, (x, y), 0.55 * math.sin(at), -0.35 - 0.35 * math.cos(at), (62, 62))

    def arm(name: str, at: float) -> Line:
        return limb(name, shoulder, 0.6 * math.sin(at), 0.45 + 0.2 * math.sin(at), (44, 40))

    return (
        arm("far arm", phase),
        leg("far leg", phase + math.pi),
        Line("trunk", spline([(x, y), (x - 3, y - 45), shoulder]), BODY_WIDTH, BLACK),
        Line("head", ellipse((x + 8, y - 112), (22, 25)), BODY_WIDTH, BLACK, True),
        leg("near leg", phase),
        arm("near arm", phase + math.pi),
    )

"""Key drawings of our own, far apart: whole limbs swing between two of them, and short lines come and go."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from samples.scene import Drawing, Fill, Line, Movie, ellipse, hose, place, spline

__all__ = ["FAR_KEYS"]

Floats = NDArray[np.float64]
Point = tuple[float, float]

SIDE = 512
BLACK = (0, 0, 0)
WIDTH = 3.0
DANCER = (
    ((0, 0), 0, (-20, 35), (25, -30), (15, -10), (-15, 20)),
    ((14, -6), 8, (25, 60), (70, -45), (40, -50), (-30, 40)),
    ((34, 4), -6, (65, 85), (110, -20), (75, -70), (-12, 12)),
    ((10, 12), 14, (100, 30), (60, -75), (30, -25), (-45, 70)),
)
"""Of each drawing: shift, lean, then turn of upper and lower right arm, left arm, right leg and left leg. degrees"""
CRANE = (
    ((0, 0), 0, (-20, 10), (10, 20), 0),
    ((-18, 20), -8, (-55, -30), (40, 35), 25),
    ((-30, 46), 5, (15, 60), (55, 40), -15),
    ((6, 30), 16, (50, 10), (30, -25), 30),
)
"""Of each drawing: shift, lean, then turn of the inner and outer left wing, of neck and head, and of the legs."""


def dancer(key: int) -> Drawing:
    """Somebody in wide clothes: limbs of two sides each, folds that are there on some drawings only."""
    shift, lean, right_arm, left_arm, right_leg, left_leg = DANCER[key]
    folds = {
        1: (_line("fold hip", (236, 262), (252, 274), (272, 270)), _line("fold side", (214, 214), (222, 232))),
        2: (_line("fold hip", (236, 266), (254, 272), (272, 264)), _line("fold chest", (240, 184), (256, 200))),
        3: (_line("fold chest", (238, 186), (252, 202)),),
    }
    items: list[Line | Fill] = [
        *_limb("right leg", (240, 300), right_leg, (80, 76), 20, 180),
        *_limb("left leg", (272, 300), left_leg, (80, 76), 20, 180),
        _line("side 1", (214, 168), (222, 214), (216, 262), (226, 300)),
        _line("side 2", (296, 168), (288, 214), (294, 262), (286, 300)),
        _line("belt 1", (219, 246), (256, 254), (291, 246)),
        _line("belt 2", (217, 258), (256, 266), (293, 258)),
        _line("neck", (244, 164), (254, 172), (268, 164)),
        *folds.get(key, ()),
        *_limb("right arm", (222, 172), right_arm, (62, 58), 15, -120),
        *_limb("left arm", (290, 172), left_arm, (62, 58), 15, 120),
        *place(_head(), turn=0.8 * lean, about=(256, 160)),
    ]
    return place(items, shift, lean, 1.0, (256, 300))


def crane(key: int) -> Drawing:
    """A bird with two wings of three feathers each, a long neck, thin legs."""
    shift, lean, wing, neck, legs = CRANE[key]
    body = (256.0, 270.0)
    items: list[Line | Fill] = [
        *_feathers("far wing", (270, 250), (-wing[0] - 30, -wing[1]), -1),
        _line("back", (200, 262), (240, 240), (290, 244), (340, 280)),
        _line("belly", (200, 262), (224, 300), (276, 312), (340, 280)),
        *(_line(f"tail {k}", (338, 280), (366, 278 + 14 * k), (392, 272 + 26 * k)) for k in range(3)),
        *_feathers("near wing", (248, 262), wing, 1),
        *place(_neck(neck[1]), turn=neck[0], about=(202, 264)),
        *(
            item
            for k, x in enumerate((250, 276))
            for item in place(_leg(f"leg {k}", x), turn=legs * (-1) ** k, about=(x, 306))
        ),
    ]
    return place(items, shift, lean, 1.0, body)


def _line(name: str, *points: Point) -> Line:
    return Line(name, spline(points), WIDTH, BLACK)


def _limb(
    name: str, root: Point, turns: tuple[float, float], lengths: tuple[float, float], radius: float, rest: float
) -> Drawing:
    """Two sides, a cuff, and a hand or foot; ``rest`` is the direction that no turn gives, clockwise from upwards."""
    at, joints, heading = np.array(root), [np.array(root)], rest
    for turn, length in zip(turns, lengths, strict=True):
        heading += turn
        step = np.array([math.sin(math.radians(heading)), -math.cos(math.radians(heading))])
        at = at + length * step
        joints.append(at)
    middle = (joints[0] + joints[1]) / 2
    one, other = hose(spline([joints[0], middle, joints[1], joints[2]]), radius)
    across = np.array([-step[1], step[0]])
    outline = np.concatenate([one, spline([one[-1], other[-1]])[1:], other[::-1][1:], spline([other[0], one[0]])[1:]])
    knee = joints[1] - 0.2 * radius * across
    return (
        Fill(outline),
        Line(f"{name} 1", one, WIDTH, BLACK),
        Line(f"{name} 2", other, WIDTH, BLACK),
        Line(f"{name} cuff", spline([one[-1], at + 3 * step, other[-1]]), WIDTH, BLACK),
        Line(f"{name} bend", spline([knee, knee + 0.5 * radius * across + 2 * step]), WIDTH, BLACK),
        Line(
            f"{name} end",
            spline(
                [
                    at + 5 * across,
                    at + 16 * step + 8 * across,
                    at + 24 * step,
                    at + 14 * step - 8 * across,
                    at - 5 * across,
                ]
            ),
            WIDTH,
            BLACK,
        ),
    )


def _head() -> Drawing:
    return (
        Line("head", ellipse((256, 130), (25, 30)), WIDTH, BLACK, True),
        _line("hair 1", (234, 118), (252, 112), (262, 98)),
        _line("hair 2", (280, 118), (270, 112), (262, 98)),
        _line("eye 1", (244, 128), (250, 128)),
        _line("eye 2", (262, 128), (268, 128)),
        _line("mouth", (248, 144), (257, 148), (266, 143)),
    )


def _feathers(name: str, root: Point, turns: tuple[float, float], side: int) -> Drawing:
    inner, outer = (math.radians(turn - 90 + 20 * side) for turn in (turns[0], turns[0] + turns[1]))
    elbow = np.array(root) + 70 * np.array([math.cos(inner), math.sin(inner)])
    tip = elbow + 80 * np.array([math.cos(outer), math.sin(outer)])
    lines: list[Line | Fill] = [Line(f"{name} edge", spline([root, elbow, tip]), WIDTH, BLACK)]
    for k, share in enumerate((0.25, 0.6, 1.0)):
        start = elbow + share * (tip - elbow)
        drop = np.array([38.0 - 10 * k, 46.0 - 4 * k])
        lines.append(Line(f"{name} feather {k}", spline([start, start + drop * (1, 0.4), start + drop]), WIDTH, BLACK))
    return tuple(lines)


def _neck(turn: float) -> Drawing:
    head: Drawing = (
        Line("head", spline([(150, 150), (134, 142), (116, 152), (120, 168), (146, 168)]), WIDTH, BLACK),
        _line("beak 1", (118, 154), (92, 162), (70, 172)),
        _line("beak 2", (121, 167), (96, 170), (70, 172)),
        Line("eye", ellipse((132, 154), (4, 4)), WIDTH, BLACK, True),
    )
    return (
        _line("neck 1", (206, 256), (170, 226), (176, 184), (150, 150)),
        _line("neck 2", (202, 272), (158, 232), (162, 190), (146, 168)),
        *place(head, turn=turn, about=(148, 160)),
    )


def _leg(name: str, x: float) -> Drawing:
    return (
        _line(name, (x, 308), (x + 8, 352), (x - 2, 400)),
        _line(f"{name} toe 1", (x - 2, 400), (x - 20, 408)),
        _line(f"{name} toe 2", (x - 2, 400), (x + 10, 412)),
    )


def _movie(name: str, draw: Callable[[int], Drawing], keys: int) -> Movie:
    return Movie.on_ones(name, (SIDE, SIDE), [draw(key) for key in range(keys)])


FAR_KEYS: dict[str, Callable[[], Movie]] = {
    "keys dancer": lambda: _movie("keys dancer", dancer, len(DANCER)),
    "keys crane": lambda: _movie("keys crane", crane, len(CRANE)),
}
"""Key drawings by name."""

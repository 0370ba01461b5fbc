"""Who plays in the samples: a robot, a cat, a ball and a snail, each drawn from a handful of numbers."""

from __future__ import annotations

import math

import numpy as np

from samples.scene import Drawing, Fill, Line, ellipse, flatten_curve, hose, place, polygon, rounded, spline

__all__ = ["ball", "cat", "gadgets", "pillar", "robot", "snail"]

INK = (28, 32, 48)
CORAL = (232, 84, 70)
TEAL = (22, 150, 140)
BLACK = (0, 0, 0)

HALF_HEART = np.array([(0, 22), (-11, 12), (-27, 1), (-27, -12), (-27, -26), (-7, -28), (0, -12)], float)
"""From its tip up its left side to the notch."""


def robot(phase: float, blink: float, spark: float) -> Drawing:
    """A robot that waves and holds a balloon, on 512 x 512 px.

    Args:
        phase: Of its wave, in [0, 1).
        blink: How far its eyes are closed, in [0, 1].
        spark: How far the three lines beside its hand are drawn, in [0, 1].
    """
    swing, bob = math.sin(2 * math.pi * phase), 4 * math.cos(4 * math.pi * phase)
    body = (256.0, 338.0 + bob)
    sway = 0.5 - 0.5 * math.cos(2 * math.pi * phase)
    return (
        _ground(),
        *_balloon((body[0] - 142 + 128 * sway, 112 + 94 * sway**2), (body[0] - 108, body[1] + 12)),
        *_legs(body),
        *_arm("left arm", [(body[0] - 54, body[1] - 34), (body[0] - 92, body[1] - 14), (body[0] - 108, body[1] + 12)]),
        *_torso(body),
        *place(_head(blink, swing), shift=(body[0], body[1] - 128), turn=5 * swing),
        *_waving_arm(body, swing, spark),
    )


def _ground() -> Line:
    return Line("ground", spline([(70, 470), (200, 473), (330, 469), (446, 472)]), 4, INK)


def _balloon(center: tuple[float, float], hand: tuple[float, float]) -> Drawing:
    x, y = center
    knot = (x + 2, y + 61)
    skin = spline([(x, y - 58), (x + 46, y - 18), (x + 30, y + 34), knot, (x - 28, y + 34), (x - 46, y - 18)],
                  is_closed=True)  # fmt: skip
    middle = ((knot[0] + hand[0]) / 2 - 16, (knot[1] + hand[1]) / 2 + 10)
    return (
        Line("string", spline([knot, middle, hand]), 3, INK),
        Fill(skin),
        Line("balloon", skin, 5, CORAL, is_closed=True),
        Line("balloon shine", ellipse((x, y - 10), (28, 32), 195, 62), 4, CORAL),
    )


def _legs(body: tuple[float, float]) -> Drawing:
    items: list[Line | Fill] = []
    for side, name in ((-1, "left"), (1, "right")):
        foot = (256 + side * 44, 452.0)
        axis = spline([(body[0] + side * 26, body[1] + 50), (256 + side * 33, body[1] + 84), (foot[0] - side * 6, 446)])
        sides = hose(axis, 11)
        sole = spline([(foot[0] - 32, 468), (foot[0] - 26, 446), (foot[0], 436), (foot[0] + 26, 446),
                       (foot[0] + 32, 468)])  # fmt: skip
        items += [Line(f"{name} leg {k}", points, 5, INK) for k, points in enumerate(sides, start=1)]
        items += [Fill(np.concatenate([sole, polygon([sole[-1], sole[0]])[1:]])), Line(f"{name} foot", sole, 5, INK)]
    return tuple(items)


def _arm(name: str, joints: list[tuple[float, float]]) -> Drawing:
    sides = hose(spline(joints), 10)
    hand = ellipse(joints[-1], (19, 19))
    outline = np.concatenate([sides[0], polygon([sides[0][-1], sides[1][-1]])[1:], sides[1][::-1][1:],
                              polygon([sides[1][0], sides[0][0]])[1:]])  # fmt: skip
    return (
        Fill(outline),
        *(Line(f"{name} {k}", points, 5, INK) for k, points in enumerate(sides, start=1)),
        Fill(hand),
        Line(f"{name} hand", hand, 5, INK, is_closed=True),
    )


def _waving_arm(body: tuple[float, float], swing: float, spark: float) -> Drawing:
    shoulder, elbow = (body[0] + 54, body[1] - 34), (body[0] + 106, body[1] - 30)
    angle = math.radians(-72 + 24 * swing)
    hand = (elbow[0] + 88 * math.cos(angle), elbow[1] + 88 * math.sin(angle))
    arm = _arm("right arm", [shoulder, ((shoulder[0] + elbow[0]) / 2, shoulder[1] + 12), elbow, hand])
    rays = []
    for number, degrees in enumerate((-112, -78, -44), start=1):
        ray = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])
        reach = np.array(hand) + np.outer((33, 44, 55), ray)
        rays.append(Line(f"spark {number}", spline(reach), 5, TEAL, drawn=(0.0, spark)))
    return (*arm, *rays)


def _torso(body: tuple[float, float]) -> Drawing:
    x, y = body
    shell = rounded(body, (62, 58), 26)
    at = np.array([x, y - 2])
    left = HALF_HEART + at
    right = HALF_HEART * (-1, 1) + at
    return (
        Fill(shell),
        Line("torso", shell, 5, INK, is_closed=True),
        Line("heart left", left, 5, CORAL),
        Line("heart right", right, 5, CORAL),
        Line("belt", spline([(x - 59, y + 36), (x, y + 42), (x + 59, y + 36)]), 4, INK),
    )


def _head(blink: float, swing: float) -> Drawing:
    """Centred on the origin; its neck ends at y = 70."""
    skull = rounded((0, 0), (86, 60), 40)
    face = rounded((0, 4), (64, 40), 28)
    eyes = [ellipse((x, -2), (11, max(1.2, 13 * (1 - blink)))) for x in (-28, 28)]
    antenna = spline([(0, -60), (6 * swing, -82), (16 * swing, -104)])
    ball = ellipse((18 * swing, -116), (12, 12))
    ears = [spline([(s * 85, -20), (s * 102, -14), (s * 104, 2), (s * 101, 17), (s * 85, 22)]) for s in (-1, 1)]
    return (
        *(Line(f"neck {k}", polygon([(x, 58), (x, 76)]), 5, INK) for k, x in ((1, -16), (2, 16))),
        *(Line(f"ear {k}", ear, 5, INK) for k, ear in enumerate(ears, start=1)),
        Line("antenna", antenna, 5, INK),
        Fill(ball),
        Line("antenna ball", ball, 5, CORAL, is_closed=True),
        Fill(skull),
        Line("head", skull, 5, INK, is_closed=True),
        Line("face", face, 4, INK, is_closed=True),
        *(Line(f"eye {k}", eye, 5, INK, is_closed=True) for k, eye in enumerate(eyes, start=1)),
        Line("smile", spline([(-20, 21), (0, 30), (20, 21)]), 5, INK),
    )


def cat(tail: float, blink: float, heart: float, ear: float) -> Drawing:
    """A sitting cat whose tail sweeps behind it, on 420 x 420 px, in black.

    Args:
        tail: Where its tail points, from -1 (left) to 1 (right).
        blink: How far its eyes are closed, in [0, 1].
        heart: How far the heart over its head is drawn, in [0, 1].
        ear: How far its right ear twitches, in [0, 1].
    """
    base = np.array([214.0, 360.0])
    reach = np.array([[0, 0], [66, 4], [114, -30], [124, -84], [146, -134]]) * (tail, 0.55 + 0.45 * abs(tail))
    tail_sides = _tail(base + reach)
    body = spline([(150, 196), (126, 250), (112, 320), (122, 372), (160, 388), (214, 390), (266, 388), (306, 372),
                   (314, 318), (300, 250), (274, 196)])  # fmt: skip
    closed = np.concatenate([body, polygon([body[-1], body[0]])[1:]])
    return (
        *tail_sides,
        Fill(closed),
        Line("body", body, 4, BLACK),
        *_paws(),
        *_cat_head(blink, ear),
        *_heart(heart),
    )


def _tail(axis: np.ndarray) -> Drawing:
    curve = flatten_curve(spline(axis), 12)
    tangent = np.gradient(curve, axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1) / np.linalg.norm(tangent, axis=1, keepdims=True)
    width = np.linspace(15, 11, len(curve))[:, None]
    picked = np.linspace(0, len(curve) - 1, 6).round().astype(int)
    tip = curve[-1] + tangent[-1] / np.linalg.norm(tangent[-1]) * 11
    left, right = (curve + width * normal)[picked], (curve - width * normal)[picked]
    return (Line("tail", spline([*left, tip, *right[::-1]]), 4, BLACK),)


def _paws() -> Drawing:
    items: list[Line | Fill] = []
    for side, name in ((-1, "left"), (1, "right")):
        x = 214 + side * 30
        paw = spline([(x - 20, 391), (x - 28, 379), (x, 363), (x + 28, 379), (x + 20, 391)], is_closed=True)
        items += [
            Line(f"{name} leg", spline([(x - side * 22, 290), (x - side * 20, 330), (x - side * 22, 368)]), 4, BLACK),
            Fill(paw),
            Line(f"{name} paw", paw, 4, BLACK, is_closed=True),
            *(Line(f"{name} toe {k}", polygon([(x + d, 376), (x + d, 388)]), 3, BLACK) for k, d in ((1, -8), (2, 8))),
        ]
    return tuple(items)


def _cat_head(blink: float, ear: float) -> Drawing:
    skull = spline([(214, 232), (140, 214), (116, 158), (140, 108), (214, 94), (288, 108), (312, 158), (288, 214)],
                   is_closed=True)  # fmt: skip
    left = spline([(130, 130), (122, 84), (130, 52), (158, 70), (184, 100)])
    right = spline([(298, 130), (306, 84), (298 + 9 * ear, 52 + 9 * ear), (270 + 3 * ear, 70 + 4 * ear), (244, 100)])
    inner = [spline([(142, 106), (140, 80), (164, 96)]), spline([(286, 106), (288 + 4 * ear, 80 + 4 * ear), (264, 96)])]
    items: list[Line | Fill] = [Line("left ear", left, 4, BLACK), Line("right ear", right, 4, BLACK)]
    items += [Line(f"inner ear {k}", points, 3, BLACK) for k, points in enumerate(inner, start=1)]
    items += [Fill(skull), Line("head", skull, 4, BLACK, is_closed=True)]
    for k, x in ((1, 172.0), (2, 256.0)):
        items.append(Line(f"eye {k}", ellipse((x, 156), (13, max(1.0, 17 * (1 - blink)))), 4, BLACK, is_closed=True))
    items += [
        Line("nose", spline([(204, 180), (214, 177), (224, 180), (214, 190)], is_closed=True), 4, BLACK),
        Line("mouth left", spline([(214, 191), (208, 204), (190, 203)]), 4, BLACK),
        Line("mouth right", spline([(214, 191), (220, 204), (238, 203)]), 4, BLACK),
    ]
    for side, name in ((-1, "left"), (1, "right")):
        for k, (start, end) in enumerate(((180, 170), (190, 192), (200, 214)), start=1):
            whisker = spline(
                [(214 + side * 60, start), (214 + side * 98, (start + end) / 2 - 4), (214 + side * 138, end)]
            )
            items.append(Line(f"{name} whisker {k}", whisker, 2, BLACK))
    return tuple(items)


def _heart(drawn: float) -> Drawing:
    points = np.concatenate([HALF_HEART, HALF_HEART[::-1][1:] * (-1, 1)]) * 1.15 + np.array([352, 66])
    return (Line("heart", points, 4, BLACK, drawn=(0.0, drawn)),)


def ball(center: tuple[float, float], impact: float, turn: float, squash: float, dust: float) -> Drawing:
    """A striped ball that bounces, on 401 x 301 px, in three colours.

    Args:
        center: Of the ball. px
        impact: Where it last hit the floor. px
        turn: Of its stripes, clockwise. degrees
        squash: Its height over its width.
        dust: How far the lines of its impact are drawn, in [0, 1].
    """
    red, blue, grey = (220, 60, 50), (40, 90, 200), (120, 120, 120)
    skin = ellipse((0, 0), (52, 52))
    stripes = [spline([(-43, s * 29), (-16, s * 19), (16, s * 19), (43, s * 29)]) for s in (-1, 1)]
    spokes = np.radians(np.arange(0, 360, 36) - 90)
    reach = np.where(np.arange(10) % 2, 6, 14)
    star = polygon(
        [(r * math.cos(a), r * math.sin(a)) for a, r in zip([*spokes, spokes[0]], [*reach, 14], strict=True)]
    )
    toy: Drawing = (
        Fill(skin),
        Line("ball", skin, 5, red, is_closed=True),
        *(Line(f"stripe {k}", points, 4, blue) for k, points in enumerate(stripes, start=1)),
        Line("star", star, 4, blue, is_closed=True),
    )
    wide = (math.sqrt(1 / squash), math.sqrt(squash))
    turned = place(place(toy, turn=turn), scale=wide, shift=center)
    puffs = []
    for number, (side, lift) in enumerate(((-1, 4), (-1, 16), (1, 4), (1, 16)), start=1):
        x = impact + side * 72
        arc = spline([(x, 262 - lift), (x + side * 14, 254 - 1.6 * lift), (x + side * 30, 256 - 1.9 * lift)])
        puffs.append(Line(f"dust {number}", arc, 4, grey, drawn=(0.0, dust)))
    return (Line("floor", polygon([(24, 268), (377, 268)]), 5, grey), *turned, *puffs)


def snail() -> Drawing:
    """A snail on a mushroom, on 480 x 480 px, in black."""
    return (*_mushroom(), *_snail_body(), *_grass())


def _mushroom() -> Drawing:
    cap = spline([(96, 330), (110, 262), (180, 222), (250, 216), (322, 224), (388, 264), (402, 330), (330, 352),
                  (250, 358), (166, 352)], is_closed=True)  # fmt: skip
    stem = [spline([(206, 356), (214, 400), (200, 446)]), spline([(294, 356), (288, 400), (304, 446)])]
    dots = [ellipse(center, radius) for center, radius in
            (((160, 290), (20, 14)), ((246, 312), (26, 17)), ((338, 286), (19, 13)), ((296, 336), (9, 6)),
             ((196, 334), (8, 6)))]  # fmt: skip
    return (
        Line("mushroom cap", cap, 4, BLACK, is_closed=True),
        *(Line(f"stem {k}", points, 4, BLACK) for k, points in enumerate(stem, start=1)),
        *(Line(f"dot {k}", points, 3, BLACK, is_closed=True) for k, points in enumerate(dots, start=1)),
        Line("gill 1", spline([(226, 372), (232, 396), (228, 424)]), 2, BLACK),
        Line("gill 2", spline([(262, 374), (264, 392), (268, 408)]), 2, BLACK),
    )


def _snail_body() -> Drawing:
    angle = np.radians(np.arange(0, 901, 45) + 90)
    radius = np.linspace(84, 7, len(angle))
    spiral = np.stack([232 + radius * np.cos(angle), 144 + radius * np.sin(angle)], axis=1)
    foot = spline([(112, 242), (150, 228), (232, 224), (312, 220), (340, 190), (338, 146), (352, 118), (378, 116),
                   (393, 138), (388, 184), (372, 226), (330, 246), (240, 236), (160, 240)], is_closed=True)  # fmt: skip
    rim = ellipse((232, 144), (84, 84), 90)
    return (
        Line("eye stalk 1", spline([(360, 116), (352, 88), (336, 68)]), 4, BLACK),
        Line("eye stalk 2", spline([(376, 116), (384, 86), (398, 64)]), 4, BLACK),
        Line("eye 1", ellipse((331, 60), (9, 9)), 4, BLACK, is_closed=True),
        Line("eye 2", ellipse((403, 56), (9, 9)), 4, BLACK, is_closed=True),
        Fill(foot),
        Line("snail body", foot, 4, BLACK, is_closed=True),
        Line("snail smile", spline([(364, 152), (373, 157), (384, 151)]), 3, BLACK),
        Fill(rim),
        Line("shell", rim, 4, BLACK, is_closed=True),
        Line("shell spiral", spline(spiral[1:]), 4, BLACK),
    )


def _grass() -> Drawing:
    blades = [[(70, 452), (62, 426), (48, 408)], [(84, 452), (86, 420), (96, 396)], [(98, 452), (110, 432), (126, 424)],
              [(392, 452), (384, 424), (370, 410)], [(408, 452), (410, 418), (420, 392)],
              [(422, 452), (434, 432), (450, 424)]]  # fmt: skip
    ground = Line("ground", spline([(36, 452), (150, 448), (250, 451), (350, 447), (446, 452)]), 4, BLACK)
    return (ground, *(Line(f"blade {k}", spline(blade), 3, BLACK) for k, blade in enumerate(blades, start=1)))


def pillar(left: float, width: float, size: tuple[int, int]) -> Drawing:
    """A white pillar over the whole height of the page, which hides what it passes. px"""
    top, bottom = -10.0, size[1] + 10.0
    shape = polygon([(left, top), (left + width, top), (left + width, bottom), (left, bottom), (left, top)])
    return (
        Fill(shape),
        Line("pillar left", polygon([(left, top), (left, bottom)]), 4, BLACK),
        Line("pillar right", polygon([(left + width, top), (left + width, bottom)]), 4, BLACK),
    )


def gadgets(turn: float) -> Drawing:
    """Six things on 512 x 512 px, of which every other one turns the other way. degrees"""
    things: tuple[Drawing, ...] = (_key(), _fish(), _leaf(), _spoon(), _arrow(), _mug())
    items: list[Line | Fill] = []
    for number, thing in enumerate(things):
        center = (96 + 160 * (number % 3), 150 + 212 * (number // 3))
        items += place(thing, turn=turn * (-1) ** number + 20 * number, shift=center)
    return tuple(items)


def _key() -> Drawing:
    return (
        Line("key bow", ellipse((0, -38), (22, 22)), 4, BLACK, is_closed=True),
        Line("key shaft", polygon([(0, -16), (0, 58)]), 4, BLACK),
        Line("key tooth 1", polygon([(0, 56), (18, 56)]), 4, BLACK),
        Line("key tooth 2", polygon([(0, 40), (13, 40)]), 4, BLACK),
    )


def _fish() -> Drawing:
    back = spline([(50, 0), (16, -24), (-26, -14), (-48, 6)])
    belly = spline([(50, 0), (18, 22), (-24, 12), (-48, -8)])
    return (
        Line("fish back", back, 4, BLACK),
        Line("fish belly", belly, 4, BLACK),
        Line("fish tail", spline([(-48, 6), (-58, 20), (-54, 0), (-60, -18), (-48, -8)]), 4, BLACK),
        Line("fish eye", ellipse((30, -5), (4, 4)), 3, BLACK, is_closed=True),
        Line("fish gill", spline([(14, -14), (8, 0), (14, 13)]), 3, BLACK),
    )


def _leaf() -> Drawing:
    return (
        Line("leaf left", spline([(0, 34), (-28, 8), (-20, -28), (0, -56)]), 4, BLACK),
        Line("leaf right", spline([(0, 34), (24, 12), (22, -24), (0, -56)]), 4, BLACK),
        Line("leaf stalk", spline([(0, -34), (2, 20), (-8, 60)]), 3, BLACK),
        Line("leaf vein", spline([(1, 4), (10, -6), (14, -14)]), 3, BLACK),
    )


def _spoon() -> Drawing:
    return (
        Line("spoon bowl", ellipse((0, -36), (17, 25)), 4, BLACK, is_closed=True),
        Line("spoon handle", spline([(0, -11), (-3, 24), (4, 62)]), 4, BLACK),
        Line("spoon shine", ellipse((0, -36), (9, 16), 180, 70), 3, BLACK),
    )


def _arrow() -> Drawing:
    return (
        Line("arrow shaft", spline([(-52, 10), (-10, -8), (46, -2)]), 4, BLACK),
        Line("arrow head", polygon([(28, -22), (48, -2), (24, 14)]), 4, BLACK),
        Line("feather 1", polygon([(-52, 10), (-60, -6)]), 4, BLACK),
        Line("feather 2", polygon([(-38, 3), (-46, -13)]), 4, BLACK),
    )


def _mug() -> Drawing:
    return (
        Line("mug rim", ellipse((0, -32), (28, 8)), 4, BLACK, is_closed=True),
        Line("mug wall", spline([(-28, -32), (-27, 0), (-24, 28), (0, 34), (24, 28), (27, 0), (28, -32)]), 4, BLACK),
        Line("mug handle", spline([(28, -18), (50, -14), (48, 10), (27, 16)]), 4, BLACK),
        Line("mug steam", spline([(-4, -46), (-10, -56), (0, -62), (-6, -72)]), 3, BLACK),
    )

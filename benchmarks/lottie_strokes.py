"""True strokes of a Lottie animation: a reader of shape layers for the benchmarks, apart from the package's own writer.

Follows the Lottie specification (lottie.github.io/lottie-spec): shape layers with parents, groups, paths, ellipses,
rectangles, strokes and trimmed paths. Whatever else is seen (fills, masks, mattes, images, precompositions, repeaters,
dashes) is an error, so that no animation is read half.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from videovec.curves import arc_length, evaluate, parameter_at, segments_of, sub_curve

Floats = NDArray[np.float64]
Json = Any

ROUND = 0.5519
"""Length of the handles of a quarter circle, of its radius, as Lottie players draw it."""
CAPS = ("butt", "round", "square")
JOINS = ("miter", "round", "bevel")
_FLAT = 1e-9


class UnreadableError(ValueError):
    """An animation holds what this reader does not know."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A spline of one frame.

    Args:
        points: Control points, 3 n + 1. [P, 2] px
        closed: Whether it ends where it begins.
    """

    points: Floats
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class DrawnStroke:
    """A path and its pen.

    Args:
        name: The same on every frame.
        points: Control points, 3 n + 1. [P, 2] px
        closed: Whether it ends where it begins.
        width: px
        cap: As SVG names it.
        join: As SVG names it.
        colour: Red, green and blue in [0, 1].
    """

    name: str
    points: Floats
    closed: bool
    width: float
    cap: str
    join: str
    colour: tuple[float, ...]

    def scaled(self, factor: float) -> DrawnStroke:
        """The same on a larger page."""
        return replace(self, points=self.points * factor, width=self.width * factor)


def strokes_at(animation: Json, frame: float) -> list[DrawnStroke]:
    """All strokes of a frame, the hindmost first, in the animation's own px.

    Raises:
        UnreadableError: It holds what this reader does not know.
    """
    layers = animation["layers"]
    if any(asset.get("layers") for asset in animation.get("assets", [])):
        raise UnreadableError("precompositions")
    by_index = {layer.get("ind", -1 - n): layer for n, layer in enumerate(layers)}
    drawn: list[DrawnStroke] = []
    for n, layer in reversed(list(enumerate(layers))):
        if layer["ty"] == 3 or layer.get("hd") or not layer["ip"] <= frame < layer["op"]:
            continue
        if layer["ty"] != 4 or layer.get("hasMask") or layer.get("tt") or layer.get("ddd"):
            raise UnreadableError(f"a layer of type {layer['ty']}, or a masked one")
        matrix, opacity = _to_page(layer, by_index, frame), _number(layer["ks"].get("o"), frame, 100.0)
        if _is_seen(opacity):
            drawn += reversed(list(_strokes_of(layer["shapes"], matrix, frame, f"L{n}")))
    if len({stroke.colour for stroke in drawn}) > 1:
        raise UnreadableError("pens of several colours")
    return drawn


def _to_page(layer: Json, by_index: dict[int, Json], time: float) -> Floats:
    matrix = _matrix(layer["ks"], time)
    while (layer := by_index.get(layer.get("parent", object()))) is not None:
        matrix = _matrix(layer["ks"], time) @ matrix
    return matrix


def _matrix(transform: Json, time: float) -> Floats:
    """A transform as a matrix of homogeneous coordinates. [3, 3]"""
    if _number(transform.get("sk"), time, 0.0):
        raise UnreadableError("a skewed transform")
    anchor, place = _vector(transform.get("a"), time, (0, 0)), _vector(transform.get("p"), time, (0, 0))
    scale = _vector(transform.get("s"), time, (100, 100)) / 100
    angle = np.radians(_number(transform.get("r"), time, 0.0))
    matrix = np.eye(3)
    matrix[:2, :2] = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag(scale)
    matrix[:2, 2] = place - matrix[:2, :2] @ anchor
    return matrix


def _strokes_of(items: Json, matrix: Floats, time: float, name: str) -> Iterator[DrawnStroke]:
    """Strokes of a list of shapes, the foremost first; one pen draws all paths above it."""
    paths, pens = _paths_of(items, matrix, time, name), []
    for n, item in enumerate(items):
        if item.get("hd"):
            continue
        if item["ty"] == "gr":
            inner, opacity = _inside(item, matrix, time)
            if _is_seen(opacity):
                yield from _strokes_of(item["it"], inner, time, f"{name}/{n}")
        if item["ty"] in ("fl", "gf", "gs", "rp", "rd", "zz", "op", "pb"):
            raise UnreadableError(f"a shape of type {item['ty']}")
        if item["ty"] == "st":
            pens.append(item)
    for pen in pens:
        if pen.get("d"):
            raise UnreadableError("dashes")
        scale = np.sqrt(abs(np.linalg.det(matrix[:2, :2])))
        width = _number(pen["w"], time, 0.0) * scale
        if _is_seen(_number(pen.get("o"), time, 100.0)) and width > 0:
            cap, join = CAPS[pen.get("lc", 2) - 1], JOINS[pen.get("lj", 2) - 1]
            colour = tuple(np.ravel(_value(pen["c"], time))[:3].round(3).tolist())
            for key, path in paths:
                yield DrawnStroke(key, path.points, path.closed, width, cap, join, colour)


def _is_seen(opacity: float) -> bool:
    """Whether something of this opacity in percent is drawn; what is neither drawn nor left out cannot be read."""
    if 1 < opacity < 99:
        raise UnreadableError("pens that let light through")
    return opacity >= 99


def _inside(group: Json, matrix: Floats, time: float) -> tuple[Floats, float]:
    for item in group["it"]:
        if item["ty"] == "tr":
            return matrix @ _matrix(item, time), _number(item.get("o"), time, 100.0)
    return matrix, 100.0


def _paths_of(items: Json, matrix: Floats, time: float, name: str) -> list[tuple[str, Path]]:
    """Named paths that a pen of this list draws: its own and those of groups before it that have none."""
    paths: list[tuple[str, Path]] = []
    for n, item in enumerate(items):
        key = f"{name}/{n}"
        if item.get("hd"):
            continue
        match item["ty"]:
            case "sh":
                paths.append((key, _moved(_spline(_shape(item["ks"], time)), matrix)))
            case "el":
                paths.append((key, _moved(_ellipse(item, time), matrix)))
            case "rc":
                paths.append((key, _moved(_rectangle(item, time), matrix)))
            case "gr" if not any(inner["ty"] == "st" for inner in item["it"]):
                paths += _paths_of(item["it"], _inside(item, matrix, time)[0], time, key)
            case "tm":
                paths = _trimmed(paths, item, time)
    return paths


def _moved(path: Path, matrix: Floats) -> Path:
    return Path(path.points @ matrix[:2, :2].T + matrix[:2, 2], path.closed)


def _spline(shape: Json) -> Path:
    """Vertices and tangents as control points."""
    vertices, leave, enter = (np.array(shape[key], float) for key in ("v", "o", "i"))
    closed = bool(shape.get("c"))
    order = np.append(np.arange(len(vertices)), 0) if closed else np.arange(len(vertices))
    points = [vertices[:1]]
    for a, b in pairwise(order):
        points.append(np.stack([vertices[a] + leave[a], vertices[b] + enter[b], vertices[b]]))
    return Path(np.concatenate(points), closed)


def _ellipse(item: Json, time: float) -> Path:
    centre, radius = _vector(item["p"], time, (0, 0)), _vector(item["s"], time, (0, 0)) / 2
    corners = np.array([(0, -1), (1, 0), (0, 1), (-1, 0), (0, -1)], float)
    along = np.array([(1, 0), (0, 1), (-1, 0), (0, -1), (1, 0)], float) * ROUND
    points = [corners[:1]]
    for n in range(4):
        points.append(np.stack([corners[n] + along[n], corners[n + 1] - along[n + 1], corners[n + 1]]))
    return Path(np.concatenate(points) * radius + centre, True)


def _rectangle(item: Json, time: float) -> Path:
    """From the upper right corner, clockwise."""
    centre, size = _vector(item["p"], time, (0, 0)), _vector(item["s"], time, (0, 0))
    r = min(_number(item.get("r"), time, 0.0), *(size / 2))
    x, y = size / 2
    c = r * (1 - ROUND)
    quarter = [(x, -y + r), (x, y - r), (x, y - c), (x - c, y), (x - r, y)]
    lower = [(-x + r, y), (-x + c, y), (-x, y - c), (-x, y - r)]
    upper = [(-x, -y + r), (-x, -y + c), (-x + c, -y), (-x + r, -y)]
    right = [(x - r, -y), (x - c, -y), (x, -y + c), (x, -y + r)]
    points = [np.array(quarter[0], float)]
    for arc, line_to in (
        (quarter[2:], quarter[1]),
        (lower[1:], lower[0]),
        (upper[1:], upper[0]),
        (right[1:], right[0]),
    ):
        a, b = points[-1], np.array(line_to, float)
        points += [a + (b - a) / 3, a + (b - a) * 2 / 3, b, *(np.array(p, float) for p in arc)]
    return Path(np.stack(points) + centre, True)


def _trimmed(paths: list[tuple[str, Path]], item: Json, time: float) -> list[tuple[str, Path]]:
    """Paths cut to a range of their length; each by itself, or all as one."""
    start, end, offset = (_number(item.get(key), time, d) for key, d in (("s", 0.0), ("e", 100.0), ("o", 0.0)))
    low, high = sorted(np.clip((start / 100, end / 100), 0, 1))
    if high - low >= 1:
        return paths
    if high - low <= _FLAT:
        return []
    low, high = low + offset / 360, high + offset / 360
    low, high = low - np.floor(low), high - np.floor(low)
    if item.get("m", 1) == 2:
        raise UnreadableError("paths trimmed one after the other")
    trimmed = []
    for key, path in paths:
        if high <= 1:
            parts = [_part(path.points, low, high)]
        elif path.closed:
            parts = [np.concatenate([_part(path.points, low, 1.0), _part(path.points, 0.0, high - 1)[1:]])]
        else:
            parts = [_part(path.points, low, 1.0), _part(path.points, 0.0, high - 1)]
        trimmed += [(f"{key}#{n}" if n else key, Path(p, False)) for n, p in enumerate(parts)]
    return trimmed


def _part(points: Floats, low: float, high: float) -> Floats:
    """Control points of a range of arc length."""
    if high - low <= _FLAT or arc_length(points) <= _FLAT:
        return np.repeat(points[:1], 4, axis=0)
    return sub_curve(points, np.ones(1 + len(points) // 3), low, high)[0]


def _number(value: Json, time: float, default: float) -> float:
    return float(np.ravel(_value(value, time))[0]) if value is not None else default


def _vector(value: Json, time: float, default: tuple[float, float]) -> Floats:
    if value is not None and value.get("s") is True:
        return np.array([_number(value["x"], time, 0.0), _number(value["y"], time, 0.0)])
    return np.asarray(default if value is None else np.ravel(_value(value, time))[:2], np.float64)


def _value(value: Json, time: float) -> Floats:
    """A property's numbers at a time."""
    if "x" in value and isinstance(value["x"], str):
        raise UnreadableError("expressions")
    keys = value["k"]
    if not (isinstance(keys, list) and keys and isinstance(keys[0], dict)):
        return np.ravel(np.array(keys, float))
    begin, finish, share, key = _between(keys, time)
    a, b = np.ravel(np.array(begin, float)), np.ravel(np.array(finish, float))
    if np.any(key.get("to", 0)) or np.any(key.get("ti", 0)):
        control = np.stack([a[:2], a[:2] + key["to"][:2], b[:2] + key["ti"][:2], b[:2]])
        if arc_length(control) > _FLAT:
            segment, t = parameter_at(control, np.array([np.clip(share[0], 0, 1)]))
            return np.asarray(evaluate(segments_of(control)[segment], t)[0])
    return np.asarray(a + (b - a) * np.resize(share, len(a)))


def _shape(value: Json, time: float) -> Json:
    """A path property's vertices and tangents at a time."""
    keys = value["k"]
    if isinstance(keys, dict):
        return keys
    begin, finish, share, _ = _between(keys, time)
    a, b = begin[0], finish[0]
    mixed = {n: np.array(a[n], float) * (1 - share[0]) + np.array(b[n], float) * share[0] for n in ("v", "i", "o")}
    return {**mixed, "c": a.get("c")}


def _between(keys: list[Json], time: float) -> tuple[Json, Json, Floats, Json]:
    """What stands before and after a time, how far it is between them (a number a dimension), and the keyframe."""
    at = max((n for n, key in enumerate(keys) if key["t"] <= time), default=0)
    key, after = keys[at], keys[at + 1] if at + 1 < len(keys) else None
    if time <= key["t"] or after is None or "s" not in key or key.get("h"):
        value = key["s"] if "s" in key else keys[at - 1].get("e")
        return value, value, np.zeros(1), {}
    finish = key["e"] if "e" in key else after["s"]
    x = (time - key["t"]) / (after["t"] - key["t"])
    out, into = key.get("o"), key.get("i")
    if out is None or into is None:
        return key["s"], finish, np.array([x]), key
    ways = zip(*(np.ravel(np.array(part[axis], float)) for part in (out, into) for axis in ("x", "y")), strict=False)
    return key["s"], finish, np.array([_eased(x, *way) for way in ways]), key


def _eased(x: float, x1: float, y1: float, x2: float, y2: float) -> float:
    """A cubic easing from (0, 0) to (1, 1), by bisection on x."""
    low, high = 0.0, 1.0
    for _ in range(48):
        t = (low + high) / 2
        low, high = (t, high) if 3 * (1 - t) ** 2 * t * x1 + 3 * (1 - t) * t**2 * x2 + t**3 < x else (low, t)
    return float(3 * (1 - t) ** 2 * t * y1 + 3 * (1 - t) * t**2 * y2 + t**3)

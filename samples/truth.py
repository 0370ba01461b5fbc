"""The strokes of a movie as JSON: what a vectoriser should find.

    {"size": [width, height], "frame_rate": 24, "drawing_of_frame": [0, 0, 1, ...],
     "strokes": [{"id": 1, "name": "head", "is_closed": true, "width": 5, "color": [r, g, b]}, ...],
     "drawings": [[{"id": 1, "points": [[x, y], ...], "visible": [[0, 0.4], [0.7, 1]]}, ...], ...]}

``points`` are 3n+1 cubic control points in px, x right, y down, pixel centres at +0.5; n is the same in every drawing.
``visible`` are the arc fractions that are drawn, inside the page and not behind a fill; the list is empty where a
stroke is wholly hidden. A stroke that is not there at all, before its birth or after its death, has no entry.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from samples.scene import Drawing, Fill, Line, Movie, arc_fractions, flatten_curve

__all__ = ["movie_truth", "visible_parts"]

_STEP = 0.25
"""Distance between the places of which it is asked whether they are seen, at most, about. px"""


def movie_truth(movie: Movie) -> dict[str, Any]:
    """The strokes of a movie, ready for ``json.dump``."""
    lines: dict[str, Line] = {}
    for drawing in movie.drawings:
        for item in drawing:
            if isinstance(item, Line):
                lines.setdefault(item.name, item)
    ids = {name: number for number, name in enumerate(lines, start=1)}
    return {
        "size": list(movie.size),
        "frame_rate": movie.frame_rate,
        "drawing_of_frame": list(movie.drawing_of_frame),
        "strokes": [
            {"id": ids[name], "name": name, "is_closed": line.is_closed, "width": line.width, "color": list(line.color)}
            for name, line in lines.items()
        ],
        "drawings": [_drawing_truth(drawing, ids, movie.size) for drawing in movie.drawings],
    }


def _drawing_truth(drawing: Drawing, ids: dict[str, int], size: tuple[int, int]) -> list[dict[str, Any]]:
    return [
        {
            "id": ids[item.name],
            "points": np.round(item.points, 3).tolist(),
            "visible": visible_parts(item, drawing[place + 1 :], size),
        }
        for place, item in enumerate(drawing)
        if isinstance(item, Line) and item.drawn[1] > item.drawn[0]
    ]


def visible_parts(line: Line, above: Drawing, size: tuple[int, int]) -> list[list[float]]:
    """The arc fractions of a line that are seen.

    Args:
        line: The line.
        above: What is painted after it.
        size: Width and height of the page. px
    """
    longest = float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum())
    curve = flatten_curve(line.points, max(64, round(longest / ((len(line.points) - 1) // 3) / _STEP)))
    u = arc_fractions(curve)
    seen = (u >= line.drawn[0]) & (u <= line.drawn[1])
    seen &= ((curve >= 0) & (curve <= np.array(size))).all(axis=1)
    for fill in above:
        if isinstance(fill, Fill):
            outline = flatten_curve(fill.points).astype(np.float32)
            near = np.flatnonzero(seen & (curve >= outline.min(axis=0)).all(1) & (curve <= outline.max(axis=0)).all(1))
            hidden = [cv2.pointPolygonTest(outline, (float(x), float(y)), False) > 0 for x, y in curve[near]]
            seen[near[hidden]] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(int)))
    parts = [[float(u[a]), float(u[b - 1])] for a, b in edges.reshape(-1, 2)]
    return [[round(a, 4), round(b, 4)] for a, b in parts if b > a]

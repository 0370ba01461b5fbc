"""The tutorial does what it says, on the strokes from which its clip was drawn."""

from __future__ import annotations

import doctest
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from videovec.clip import Timeline
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

ROOT = Path(__file__).parents[1]


def true_tracks(name: str) -> StrokeTracks:
    """The strokes of a sample; where one is not drawn for a while it is hidden."""
    truth = json.loads((ROOT / "samples" / "truth" / f"{name}.json").read_text(encoding="utf-8"))
    drawings = [{stroke["id"]: stroke for stroke in drawing} for drawing in truth["drawings"]]
    lives = []
    for layer, stroke in enumerate(truth["strokes"]):
        shown = [k for k, drawing in enumerate(drawings) if stroke["id"] in drawing]
        seen = [drawings[k].get(stroke["id"]) for k in range(shown[0], shown[-1] + 1)]
        points = [one["points"] if one else None for one in seen]
        points = [one or next(p for p in reversed(points[:k]) if p) for k, one in enumerate(points)]
        visible = [[one["visible"][0][0], one["visible"][-1][1]] if one and one["visible"] else [0, 0] for one in seen]
        joints = (len(drawings[shown[0]][stroke["id"]]["points"]) - 1) // 3 + 1
        life = StrokeLife(
            id=stroke["id"],
            first=shown[0],
            points=np.array(points, float),
            half_width=np.full((len(seen), joints), stroke["width"] / 2),
            opacity=np.ones(len(seen)),
            visible=np.array(visible, float),
            color=np.array(stroke["color"]) / 255,
            layer=layer,
            is_closed=stroke["is_closed"],
        )
        lives.append(life.as_strokes())
    strokes = Strokes.concatenate(lives)
    count, rate = len(truth["drawing_of_frame"]), Fraction(truth["frame_rate"])
    timeline = Timeline(
        np.array(truth["drawing_of_frame"]),
        tuple(k / rate for k in range(count)),
        count / rate,
        np.arange(1, count + 1),
    )
    rows = strokes.row_count
    width, height = truth["size"]
    return StrokeTracks(name, (height, width), np.ones(3), timeline, strokes, (), np.zeros(rows), np.ones(rows))


def test_the_tutorial_on_tracks_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    true_tracks("ball").save(tmp_path / "ball_videovec" / "tracks.npz")
    monkeypatch.chdir(tmp_path)
    outcome = doctest.testfile(str(ROOT / "samples" / "tracking.md"), module_relative=False)
    assert outcome.failed == 0
    assert outcome.attempted > 20

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from videovec.clip import Clip, Timeline
from videovec.correction import correct
from videovec.curves import evaluate, segments_of
from videovec.errors import InputError
from videovec.events import EventKind
from videovec.settings import Config, FitSettings
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.svg import svg_frame

Floats = NDArray[np.float64]

SIDE, DRAWINGS = 96, 5
CONFIG = replace(Config(), fit=FitSettings(joint_steps=30))
TOP = np.array([[20, 24], [36, 18], [52, 30], [70, 24.0]])
LOW = np.array([[20, 60], [36, 66], [52, 54], [70, 60.0]])
EXTRA = np.array([[14, 40], [14, 50], [14, 60], [14, 74.0]])
SHIFT = np.array([1.5, 1.0])


def picture(curves: list[Floats]) -> NDArray[np.uint8]:
    scale = 8
    page = np.full((SIDE * scale, SIDE * scale), 255, np.uint8)
    for points in curves:
        line = evaluate(segments_of(points)[:, None], np.linspace(0, 1, 60)[None]).reshape(-1, 2)
        cv2.polylines(page, [np.rint((line * scale - 0.5) * 16).astype(np.int32)], False, 0, 3 * scale, cv2.LINE_AA, 4)
    return np.repeat(cv2.resize(page, (SIDE, SIDE), interpolation=cv2.INTER_AREA)[..., None], 3, axis=2)


def clip_of(*curves: Floats) -> Clip:
    drawings = tuple(picture([c + d * SHIFT for c in curves]) for d in range(DRAWINGS))
    times = tuple(Fraction(d, 12) for d in range(DRAWINGS))
    return Clip("c", drawings, Timeline(np.arange(DRAWINGS), times, Fraction(5, 12), np.arange(1, DRAWINGS + 1)))


def life(identity: int, points: Floats) -> StrokeLife:
    return StrokeLife(
        id=identity,
        first=0,
        points=np.stack([points + d * SHIFT for d in range(DRAWINGS)]),
        half_width=np.full((DRAWINGS, 2), 1.5),
        opacity=np.ones(DRAWINGS),
        visible=np.tile([0.0, 1.0], (DRAWINGS, 1)),
        color=np.zeros(3),
        layer=identity,
        is_closed=False,
    )


def tracks_of(clip: Clip, *lives: StrokeLife) -> StrokeTracks:
    strokes = Strokes.concatenate([one.as_strokes() for one in lives])
    rows = strokes.row_count
    return StrokeTracks("c", (SIDE, SIDE), np.ones(3), clip.timeline, strokes, (), np.zeros(rows), np.ones(rows))


@pytest.fixture
def edited(tmp_path: Path) -> Path:
    return tmp_path / "frame_0003.svg"


def path_data(points: Floats) -> str:
    first, *rest = points.tolist()
    return f"M{first[0]},{first[1]} C" + " ".join(f"{x},{y}" for x, y in rest)


def with_path(svg: str, identity: int, points: Floats) -> str:
    """The document with another centre line for a stroke."""
    element = re.search(rf'<path[^>]*data-stroke-id="{identity}"[^>]*>', svg)
    assert element
    return svg.replace(element[0], re.sub(r'\bd="[^"]*"', f'd="{path_data(points)}"', element[0]))


def points_at(tracks: StrokeTracks, stroke: int, frame: int) -> Floats:
    return tracks[stroke].at(frame).points


def test_a_stroke_that_was_tracked_wrongly_is_put_right_on_that_frame_and_around(edited: Path) -> None:
    """The low stroke is 6 px off its ink on all frames; the artist puts it right on frame 3 alone."""
    clip = clip_of(TOP, LOW)
    wrong = life(2, LOW + np.array([0, 6]))
    tracks = tracks_of(clip, life(1, TOP), wrong)
    right = LOW + 2 * SHIFT
    edited.write_text(with_path(svg_frame(tracks, 2, "stroke"), 2, right), encoding="utf-8")
    config = replace(CONFIG, export=replace(CONFIG.export, svg_style="stroke"))
    corrected = correct(tracks, clip, [edited], config)
    np.testing.assert_allclose(points_at(corrected, 2, 2), right, atol=1e-6)
    for frame in range(DRAWINGS):
        assert np.abs(points_at(corrected, 2, frame) - LOW - frame * SHIFT).max() < 1.0
        assert np.abs(points_at(corrected, 1, frame) - TOP - frame * SHIFT).max() < 1.0


def test_a_path_of_more_segments_is_put_on_the_segments_of_its_stroke(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW + np.array([0, 4])))
    curve = evaluate(LOW, np.linspace(0, 1, 3))  # any curve of two segments
    halves = np.concatenate(
        [[curve[0]], *[a + (b - a) * np.array([[1], [2], [3]]) / 3 for a, b in (curve[:2], curve[1:])]]
    )
    edited.write_text(with_path(svg_frame(tracks, 2, "stroke"), 2, halves + 2 * SHIFT), encoding="utf-8")
    points = points_at(correct(tracks, clip, [edited], CONFIG), 2, 2)
    assert points.shape == (4, 2)
    np.testing.assert_allclose(points[[0, -1]], LOW[[0, -1]] + 2 * SHIFT, atol=1e-6)


def test_a_deleted_stroke_ends_there_and_is_gone_where_it_began(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW))
    without = re.sub(r'<path[^>]*data-stroke-id="2"[^>]*/>', "", svg_frame(tracks, 2, "stroke"))
    edited.write_text(without, encoding="utf-8")
    corrected = correct(tracks, clip, [edited], CONFIG)
    assert corrected[2].life == (0, 1)
    assert [(event.kind, event.drawing, event.ids) for event in corrected.events] == [(EventKind.DEATH, 2, (2,))]
    first = edited.with_name("frame_0001.svg")
    first.write_text(re.sub(r'<path[^>]*data-stroke-id="2"[^>]*/>', "", svg_frame(tracks, 0, "stroke")), "utf-8")
    assert correct(tracks, clip, [first], CONFIG).strokes.ids.tolist() == [1]


def test_a_new_path_becomes_a_stroke_that_is_followed(edited: Path) -> None:
    clip = clip_of(TOP, LOW, EXTRA)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW))
    new = f'<path d="{path_data(EXTRA + 2 * SHIFT)}" fill="none" stroke="#000000" stroke-width="3"/></svg>'
    edited.write_text(svg_frame(tracks, 2, "stroke").replace("</svg>", new), encoding="utf-8")
    corrected = correct(tracks, clip, [edited], CONFIG)
    assert corrected.strokes.ids.tolist() == [1, 2, 3]
    assert corrected[3].life == (0, 4)
    for frame in range(DRAWINGS):
        assert np.abs(points_at(corrected, 3, frame) - EXTRA - frame * SHIFT).max() < 1.0


def test_a_recoloured_path_recolours_its_stroke_on_every_frame_and_moves_nothing(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW))
    svg = svg_frame(tracks, 2, "stroke")
    element = re.search(r'<path[^>]*data-stroke-id="2"[^>]*>', svg)
    assert element
    assert "#000000" in element[0]
    edited.write_text(svg.replace(element[0], element[0].replace("#000000", "#c03020")), encoding="utf-8")
    corrected = correct(tracks, clip, [edited], replace(CONFIG, export=replace(CONFIG.export, svg_style="stroke")))
    np.testing.assert_allclose(corrected[2].stroke.color * 255, [192, 48, 32], atol=0.5)
    np.testing.assert_array_equal(corrected[1].stroke.color, [0, 0, 0])
    for frame in range(DRAWINGS):
        assert np.abs(points_at(corrected, 2, frame) - LOW - frame * SHIFT).max() < 1.0


def test_a_wider_path_is_as_wide_on_its_frame_and_moves_nothing(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW))
    svg = svg_frame(tracks, 2, "stroke")
    element = re.search(r'<path[^>]*data-stroke-id="2"[^>]*>', svg)
    assert element
    wider = re.sub(r'stroke-width="[^"]*"', 'stroke-width="4.5"', element[0])
    edited.write_text(svg.replace(element[0], wider), encoding="utf-8")
    corrected = correct(tracks, clip, [edited], replace(CONFIG, export=replace(CONFIG.export, svg_style="stroke")))
    np.testing.assert_allclose(corrected[2].at(2).half_width, 2.25, atol=1e-6)
    np.testing.assert_allclose(points_at(corrected, 2, 2), LOW + 2 * SHIFT, atol=1e-9)
    assert corrected[2].at(0).half_width.max() < 1.8  # the ink of other frames is no wider


def test_strokes_that_were_not_edited_stay_to_the_last_digit(edited: Path) -> None:
    """Both lie beside their ink, from where a fit would move them; one of them is put right."""
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP + 1.0), life(2, LOW + 1.0))
    right = LOW + 2 * SHIFT
    edited.write_text(with_path(svg_frame(tracks, 2, "stroke"), 2, right), encoding="utf-8")
    corrected = correct(tracks, clip, [edited], replace(CONFIG, export=replace(CONFIG.export, svg_style="stroke")))
    before, after = (StrokeLife.of(one.strokes, 0) for one in (tracks, corrected))
    np.testing.assert_array_equal(after.points, before.points)
    np.testing.assert_array_equal(after.half_width, before.half_width)
    assert np.abs(points_at(corrected, 2, 1) - LOW - SHIFT).max() < np.abs(points_at(tracks, 2, 1) - LOW - SHIFT).max()


def test_a_correction_of_a_still_is_kept_as_it_was_drawn(edited: Path) -> None:
    clip = Clip("c", (picture([TOP, LOW]),), Timeline(np.zeros(1, int), (Fraction(0),), Fraction(1), np.ones(1, int)))
    lives = [replace(one, points=one.points[:1], half_width=one.half_width[:1]) for one in (life(1, TOP), life(2, LOW))]
    lives = [replace(one, opacity=one.opacity[:1], visible=one.visible[:1]) for one in lives]
    tracks = tracks_of(clip, *lives)
    still = edited.with_name("frame_0001.svg")
    still.write_text(with_path(svg_frame(tracks, 0, "stroke"), 2, LOW + 4), encoding="utf-8")
    corrected = correct(tracks, clip, [still], replace(CONFIG, export=replace(CONFIG.export, svg_style="stroke")))
    assert corrected.strokes.ids.tolist() == [1, 2]
    np.testing.assert_allclose(points_at(corrected, 2, 0), LOW + 4, atol=1e-6)
    np.testing.assert_array_equal(points_at(corrected, 1, 0), TOP)


def test_a_frame_that_was_not_edited_changes_nothing(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP + 1.0), life(2, LOW))
    edited.write_text(svg_frame(tracks, 2, "auto"), encoding="utf-8")
    corrected = correct(tracks, clip, [edited], CONFIG)
    assert corrected.strokes.ids.tolist() == [1, 2]
    assert corrected.events == ()
    np.testing.assert_array_equal(corrected.strokes.points, tracks.strokes.points)


def test_what_cannot_be_put_back_is_told(edited: Path) -> None:
    clip = clip_of(TOP, LOW)
    tracks = tracks_of(clip, life(1, TOP), life(2, LOW))
    svg = svg_frame(tracks, 2, "stroke")
    edited.write_text(svg.replace('data-stroke-id="2"', 'data-stroke-id="7"'), encoding="utf-8")
    with pytest.raises(InputError, match="must be that of a stroke on frame 3, got 7"):
        correct(tracks, clip, [edited], CONFIG)
    edited.write_text(
        re.sub(r'viewBox="[^"]*"', 'viewBox="0 0 96 48"', svg).replace('height="96', 'height="48'), "utf-8"
    )
    with pytest.raises(InputError, match="must have the size of the page, 96 x 96 px, got 96 x 48"):
        correct(tracks, clip, [edited], CONFIG)
    for name, reason in (("frame_0009.svg", r"must show one of the frames 1\.\.5, got 9"), ("new.svg", "named for")):
        with pytest.raises(InputError, match=reason):
            correct(tracks, clip, [edited.with_name(name)], CONFIG)

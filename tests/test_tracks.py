"""The tracking API, on strokes whose every position is known."""

from __future__ import annotations

import doctest
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np
import pyarrow.parquet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import videovec.stroke_track
import videovec.track_layouts
import videovec.track_set
import videovec.tracks
from videovec.brushwork import Brush, BrushModel, Brushwork, Laying
from videovec.clip import Timeline
from videovec.curves import arc_length, sample_by_arc
from videovec.errors import InputError, OutputError
from videovec.events import Event, EventKind
from videovec.stroke_life import StrokeLife
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks

Floats = np.typing.NDArray[np.float64]

LINE: Floats = np.array([[20.0, 20.0], [100 / 3, 20.0], [140 / 3, 20.0], [60.0, 20.0]])


def line(right: float, down: float) -> Floats:
    """A straight stroke of 40 px, moved."""
    return np.asarray(LINE + np.array([right, down]))


def life_of(stroke: int, curves: list[Floats], first: int = 0, layer: int | None = None) -> StrokeLife:
    """An opaque black stroke of half-width 1.5 px."""
    points = np.stack(curves)
    return StrokeLife(
        id=stroke,
        first=first,
        points=points,
        half_width=np.full((len(points), (points.shape[1] - 1) // 3 + 1), 1.5),
        opacity=np.ones(len(points)),
        visible=np.tile([0.0, 1.0], (len(points), 1)),
        color=np.zeros(3),
        layer=stroke if layer is None else layer,
        is_closed=False,
    )


def tracks_of(lives: list[StrokeLife], events: tuple[Event, ...] = (), exposure: int = 2) -> StrokeTracks:
    strokes = Strokes.concatenate([life.as_strokes() for life in lives])
    count = exposure * (int(strokes.layout.last.max()) + 1)
    timeline = Timeline(
        np.arange(count) // exposure,
        tuple(Fraction(k, 12) for k in range(count)),
        Fraction(count, 12),
        np.arange(1, count + 1),
    )
    rows = strokes.row_count
    return StrokeTracks("two", (80, 100), np.ones(3), timeline, strokes, events, np.zeros(rows), np.ones(rows))


@pytest.fixture
def tracks() -> StrokeTracks:
    """The tracks of the examples in ``videovec.tracks``."""
    upper = life_of(1, [line(0, 2 * k) for k in range(4)])
    upper = replace(upper, visible=np.array([[0, 1], [0, 1], [0, 1], [0, 0]], float))
    lower = life_of(2, [line(0, 30 + 2 * k) for k in range(3)])
    events = (Event(EventKind.OCCLUSION, 3, (1,)), Event(EventKind.DEATH, 3, (2,)))
    return tracks_of([upper, lower], events)


@pytest.mark.parametrize("module", [videovec.tracks, videovec.track_set, videovec.track_layouts, videovec.stroke_track])
def test_the_examples_in_the_documentation_are_true(module: ModuleType, tracks: StrokeTracks) -> None:
    outcome = doctest.testmod(module, extraglobs={"tracks": tracks})
    assert outcome.failed == 0
    assert outcome.attempted > 0 or module is not videovec.tracks


def test_a_stroke_is_where_it_was_drawn_on_every_frame_of_a_hold(tracks: StrokeTracks) -> None:
    for frame in range(8):
        np.testing.assert_array_equal(tracks[1].at(frame).points, line(0, 2 * (frame // 2)))
    assert 5 in tracks[2]
    assert 6 not in tracks[2]
    assert [shape.id for shape in tracks.at_frame(7)] == [1]
    assert not tracks.at_frame(7)[0].is_visible


def test_what_does_not_exist_is_named(tracks: StrokeTracks) -> None:
    with pytest.raises(InputError, match=r"no stroke 9; the 2 identities lie in 1\.\.2"):
        tracks[9]
    with pytest.raises(InputError, match=r"stroke 2 lives on frames 0\.\.5, got 6"):
        tracks[2].at(6)
    with pytest.raises(InputError, match=r"frame must lie in 0\.\.7, got 8"):
        tracks.at_frame(8)


@settings(max_examples=25, deadline=None)
@given(u=st.floats(0, 1), side=st.floats(-1.4, 1.4), seed=st.integers(0, 20))
def test_a_place_in_the_ink_is_found_where_it_was_put(u: float, side: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = np.cumsum(rng.uniform(0, 12, (7, 2)), axis=0) + 10  # it never turns back
    tracks = tracks_of([life_of(4, [curve])])
    dense = sample_by_arc(curve, 4001)
    k = round(u * 4000)
    tangent = dense[min(k + 1, 4000)] - dense[max(k - 1, 0)]
    normal = np.array([-tangent[1], tangent[0]]) / np.linalg.norm(tangent)
    x, y = dense[k] + side * normal
    found = tracks.query(float(x), float(y), 0, search_range=0.0)
    assert found is not None
    nearest = np.linalg.norm(dense - [x, y], axis=1)
    assert found[0] == 4
    at = dense[round(found[1] * 4000)]
    assert np.linalg.norm(at - [x, y]) <= nearest.min() + 1e-2


def test_a_query_prefers_the_upper_stroke_and_sees_no_hidden_ink(tracks: StrokeTracks) -> None:
    above = life_of(3, [line(0.5, 0.5)] * 4, layer=9)
    both = tracks_of([StrokeLife.of(tracks.strokes, 0), above])
    assert both.query(40, 20.2, 0) == pytest.approx((3, 0.4875), abs=1e-4)
    assert tracks.query(40, 26, 6) is None
    assert tracks.query(40, 40, 0, search_range=3) is None
    half = replace(above, visible=np.tile([0.5, 1.0], (4, 1)))
    found = tracks_of([half]).query(20, 20, 0)
    assert found is not None
    assert found[1] == pytest.approx(0.5)


def test_a_followed_point_is_absent_where_it_is_hidden_or_its_stroke_not_alive(tracks: StrokeTracks) -> None:
    path = tracks.follow(1, [0.0, 0.25, 1.0])
    assert path.shape == (3, 8, 2)
    np.testing.assert_allclose(path[:, 4], [[20, 24], [30, 24], [60, 24]], atol=1e-9)
    assert np.isnan(path[:, 6:]).all()
    assert np.isnan(tracks.follow(2, 0.5)[6:]).all()
    drawn_on = replace(StrokeLife.of(tracks.strokes, 0), visible=np.array([[0, 0.3], [0, 0.6], [0, 1], [0, 1]]))
    seen = np.isfinite(tracks_of([drawn_on]).follow(1, 0.5)[:, 0])
    assert seen.tolist() == [False, False, True, True, True, True, True, True]


def test_a_followed_point_stays_in_its_material_when_a_part_of_its_stroke_is_stretched(tracks: StrokeTracks) -> None:
    """A line of two segments of 20 px, the second of which grows to 60 px: its middle moves, the joint does not."""
    whole = StrokeLife.of(tracks.strokes, 0)
    x = np.array([[0.0, 20.0, 20.0 + length] for length in (20.0, 30.0, 40.0, 60.0)])
    line = np.stack([np.interp(np.arange(7) / 3, [0, 1, 2], row) for row in x])
    points = np.stack([line, np.full_like(line, 30.0)], axis=-1)
    stretched = tracks_of(
        [replace(whole, points=points, half_width=np.ones((4, 3)), visible=np.tile([0.0, 1], (4, 1)))]
    )
    path = stretched.follow(1, [0.25, 0.5, 0.75])
    np.testing.assert_allclose(path[:, ::2, 0], [[10] * 4, [20] * 4, [30, 35, 40, 50]], atol=1e-4)
    hit = stretched.query(50.0, 30.0, 6)
    assert hit == pytest.approx((1, 0.625), abs=1e-4)
    np.testing.assert_allclose(stretched.follow(1, 0.625, frame=6)[::2, 0], [30, 35, 40, 50], atol=1e-4)
    with pytest.raises(InputError, match=r"stroke 2 lives on frames 0\.\.5, got 6"):
        tracks.follow(2, 0.5, frame=6)


def test_matrices_over_frames_are_empty_outside_lives(tracks: StrokeTracks) -> None:
    np.testing.assert_array_equal(tracks.visibility[0], [1, 1, 1, 1, 1, 1, 0, 0])
    np.testing.assert_array_equal(tracks.visibility[1], [1] * 6 + [np.nan] * 2)
    rows = np.arange(7.0)
    np.testing.assert_array_equal(tracks.over_frames(rows)[1], [4, 4, 5, 5, 6, 6, np.nan, np.nan])


def test_saved_tracks_come_back_exactly(tracks: StrokeTracks, tmp_path: Path) -> None:
    rich = replace(
        tracks,
        name="größer",
        page=np.array([0.1, 0.2, 0.3]),
        error=np.linspace(0, 1, 7),
        events=(*tracks.events, Event(EventKind.SPLIT, 3, (5, 6), (1, 2), 0.25), Event(EventKind.CUT, 3, ())),
        timeline=replace(tracks.timeline, times=tuple(Fraction(1001 * k, 30000) for k in range(8))),
    )
    back = StrokeTracks.load(rich.save(tmp_path / "deep" / "tracks.npz"))
    assert (back.name, back.size, back.events) == (rich.name, rich.size, rich.events)
    assert back.timeline.times == rich.timeline.times
    assert back.timeline.duration == rich.timeline.duration
    for name in ("page", "error", "confidence"):
        np.testing.assert_array_equal(getattr(back, name), getattr(rich, name))
    for name in ("ids", "is_closed", "layer", "color", "points", "half_width", "opacity", "visible"):
        np.testing.assert_array_equal(getattr(back.strokes, name), getattr(rich.strokes, name))
    assert back.to_bytes() == rich.to_bytes()
    with np.load(tmp_path / "deep" / "tracks.npz", allow_pickle=False) as archive:
        assert int(archive["format_version"]) == 1


def test_older_tracks_of_textured_lines_have_one_shift_for_each_row(tracks: StrokeTracks, tmp_path: Path) -> None:
    layout = tracks.strokes.layout
    brush = Brush("chalk", BrushModel.TEXTURE, np.ones((8, 4)), 4.0, 2.0)
    work = Brushwork((brush,), np.zeros(len(tracks), np.intp), Laying.plain(layout))
    path = replace(tracks, brushwork=work).save(tmp_path / "tracks.npz")
    arrays = dict(np.load(path))
    of_row = np.arange(float(tracks.strokes.row_count))
    np.savez(path, **(arrays | {"brush_shift": of_row}))
    older = StrokeTracks.load(path).brushwork
    assert older is not None
    np.testing.assert_array_equal(older.laying.shift, of_row[layout.joint_row])


def test_no_strokes_are_saved_and_loaded_too(tracks: StrokeTracks, tmp_path: Path) -> None:
    nothing = tracks.drop(1, 2)
    back = StrokeTracks.load(nothing.save(tmp_path / "tracks.npz"))
    assert len(back) == 0
    assert back.at_frame(0) == []
    assert back.query(1, 1, 0) is None
    assert back.to_tapvid().points.shape == (0, 8, 2)
    assert json.loads(back.to_json())["strokes"] == []


def test_files_that_are_no_tracks_are_refused(tmp_path: Path, tracks: StrokeTracks) -> None:
    path = tmp_path / "tracks.npz"
    with pytest.raises(InputError, match="cannot read tracks"):
        StrokeTracks.load(path)
    for content in (b"", b"PK\x03\x04 torn", tracks.to_bytes()[:-200]):
        path.write_bytes(content)
        with pytest.raises(InputError, match="must be tracks that videovec saved"):
            StrokeTracks.load(path)
    np.savez(path, format_version=np.array(99))
    with pytest.raises(InputError, match="version 1, got version 99"):
        StrokeTracks.load(path)
    np.savez(path, format_version=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="must be tracks that videovec saved"):
        StrokeTracks.load(path)
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot write"):
        tracks.save(tmp_path / "file" / "tracks.npz")


def test_json_tells_where_every_stroke_is(tracks: StrokeTracks) -> None:
    document = json.loads(tracks.to_json())
    assert (document["width"], document["height"], document["frame_rate"]) == (100, 80, "12")
    assert [frame["drawing"] for frame in document["frames"]] == [0, 0, 1, 1, 2, 2, 3, 3]
    upper = document["strokes"][0]
    assert upper["drawings"][2]["points"][0] == [20.0, 24.0]
    assert upper["drawings"][3]["visible"] == [0.0, 0.0]
    assert document["events"][1] == {
        "kind": "death",
        "drawing": 3,
        "frame": 7,
        "ids": [2],
        "parents": [],
        "score": 1.0,
    }


def test_an_event_after_the_last_drawing_is_on_the_frame_after_the_last(tracks: StrokeTracks) -> None:
    ended = replace(tracks, events=(Event(EventKind.DEATH, 4, (1,)),))
    assert ended.frame_of(ended.events[0]) == 8
    assert json.loads(ended.to_json())["events"][0]["frame"] == 9


def test_a_table_has_a_row_for_every_stroke_on_every_frame(tracks: StrokeTracks, tmp_path: Path) -> None:
    frame = tracks.to_dataframe()
    assert len(frame) == 8 + 6
    third = frame[(frame.frame == 3) & (frame.id == 2)].iloc[0]
    assert (third.x, third.y, third.number) == (pytest.approx(40), pytest.approx(52), 4)
    assert third.length == pytest.approx(40)
    assert third.time == pytest.approx(0.25)
    back = pyarrow.parquet.read_table(tracks.to_parquet(tmp_path / "tracks.parquet")).to_pylist()
    assert back[0]["points"] == pytest.approx(LINE.ravel().tolist())
    assert len(back) == len(frame)


def test_pandas_is_asked_for_by_name_where_it_is_missing(tracks: StrokeTracks, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'videovec\[table\]'"):
        tracks.to_dataframe()


def test_tapvid_points_are_fractions_of_the_page_and_keep_their_last_place(tracks: StrokeTracks) -> None:
    layout = tracks.to_tapvid(spacing=40)
    np.testing.assert_array_equal(layout.ids, [1, 2])
    np.testing.assert_allclose(layout.points[0, 2], [40 / 100, 22 / 80])
    np.testing.assert_array_equal(layout.occluded[0], [False] * 6 + [True] * 2)
    np.testing.assert_allclose(layout.points[0, 7], layout.points[0, 5])
    np.testing.assert_allclose(layout.query_points[1], [0, 50, 40])


def test_napari_tracks_are_sorted_and_know_their_parents(tracks: StrokeTracks) -> None:
    layout = tracks.split(2, frame=2).to_napari(spacing=20)
    order = np.lexsort((layout.data[:, 1], layout.data[:, 0]))
    np.testing.assert_array_equal(order, np.arange(len(layout.data)))
    np.testing.assert_allclose(layout.data[0], [0, 0, 20, 30])
    child = {stroke: set(layout.data[layout.properties["stroke"] == stroke, 0]) for stroke in (1, 2, 3)}
    assert set(layout.graph) == child[3]
    assert {parent for parents in layout.graph.values() for parent in parents} <= child[2]


def dense(life: StrokeLife) -> Floats:
    """Many points of a stroke on each of its drawings. [K, 400, 2]"""
    return np.stack([sample_by_arc(points, 400) for points in life.points])


def wavy(stroke: int, drawings: int, segments: int = 3, first: int = 0, seed: int = 0) -> StrokeLife:
    rng = np.random.default_rng(seed)
    base = np.cumsum(rng.uniform(1, 9, (3 * segments + 1, 2)), axis=0)
    return life_of(stroke, [base + rng.normal(0, 0.4, base.shape) for _ in range(drawings)], first)


@pytest.mark.parametrize("u", [0.1, 0.5, 0.77])
def test_split_parts_trace_the_same_curve_and_merge_back_into_it(u: float) -> None:
    life = wavy(1, 4)
    whole = tracks_of([replace(life, visible=np.tile([0.2, 0.9], (4, 1)))])
    parts = whole.split(1, u=u)
    assert [track.id for track in parts] == [1, 2]
    lengths = [sum(arc_length(track.stroke.points[k]) for track in parts) for k in range(4)]
    np.testing.assert_allclose(lengths, [arc_length(points) for points in life.points], atol=1e-6)
    assert parts.events[-1].kind is EventKind.SPLIT
    assert parts.events[-1].parents == (1,)
    seen = [sum(np.ptp(t.stroke.visible[k]) * arc_length(t.stroke.points[k]) for t in parts) for k in range(4)]
    np.testing.assert_allclose(seen, 0.7 * np.array(lengths), atol=1e-6)
    merged = parts.merge(1, 2)
    np.testing.assert_allclose(dense(merged[1].stroke), dense(life), atol=2e-3)
    np.testing.assert_allclose(merged[1].stroke.visible, np.tile([0.2, 0.9], (4, 1)), atol=1e-6)


def test_a_split_over_time_merges_back_exactly() -> None:
    whole = tracks_of([wavy(7, 6)])
    parts = whole.split(7, frame=6)
    assert (parts[7].life, parts[8].life) == ((0, 5), (6, 11))
    merged = parts.merge(7, 8)
    np.testing.assert_array_equal(merged.strokes.points, whole.strokes.points)
    assert [str(event.kind) for event in merged.events] == ["split", "merge"]


def test_a_merge_over_a_gap_turns_the_later_stroke_round_and_hides_what_lies_between() -> None:
    early = wavy(1, 3, segments=2)
    late = replace(life_of(2, [early.points[-1] + [k, 0] for k in range(2)], first=6)).reversed()
    merged = tracks_of([early, late]).merge(1, 2)[1].stroke
    assert (merged.first, merged.last) == (0, 7)
    np.testing.assert_allclose(merged.points[6], early.points[-1], atol=1e-9)
    assert not (merged.visible[3:6, 0] < merged.visible[3:6, 1]).any()
    assert (merged.visible[6:] == [0, 1]).all()


def test_a_merge_of_different_topologies_moves_no_curve() -> None:
    early, late = wavy(1, 2, segments=2), wavy(2, 3, segments=5, first=2)
    merged = tracks_of([early, late]).merge(2, 1)
    stroke = merged[2].stroke
    assert stroke.segment_count == 5
    np.testing.assert_allclose(dense(stroke)[:2], dense(early), atol=2e-3)
    np.testing.assert_array_equal(stroke.points[2:], late.points)


def test_a_merge_bridges_a_wide_gap_with_a_straight_segment() -> None:
    left, right = life_of(1, [LINE]), life_of(2, [line(50, 0)[::-1]])
    merged = tracks_of([left, right]).merge(1, 2)[1].stroke
    assert merged.segment_count == 3
    assert arc_length(merged.points[0]) == pytest.approx(90)
    bridge = np.array([[60, 20], [190 / 3, 20], [200 / 3, 20], [70, 20]])
    np.testing.assert_allclose(merged.points[0, 3:7], bridge)


def test_merges_and_splits_that_make_no_sense_are_refused(tracks: StrokeTracks) -> None:
    with pytest.raises(InputError, match="must live on the same drawings or on none in common"):
        tracks.merge(1, 2)
    with pytest.raises(InputError, match="merged with itself"):
        tracks.merge(1, 1)
    with pytest.raises(InputError, match="arc fraction between 0 and 1, got 1"):
        tracks.split(1, u=1.0)
    with pytest.raises(InputError, match="either an arc fraction u or a frame"):
        tracks.split(1)
    with pytest.raises(InputError, match=r"can be split at drawings 1\.\.3, got 0"):
        tracks.split(1, frame=1)
    with pytest.raises(InputError, match="unused identity"):
        tracks.rename(1, 2)


def test_renaming_reaches_the_events(tracks: StrokeTracks) -> None:
    renamed = tracks.rename(2, 40)
    assert [track.id for track in renamed] == [1, 40]
    assert renamed.events_of(40)[0].kind is EventKind.DEATH
    assert not renamed.events_of(2)
    np.testing.assert_array_equal(renamed.strokes.points, tracks.strokes.points)


def test_dropping_takes_the_events_of_a_stroke_along(tracks: StrokeTracks) -> None:
    rest = tracks.drop(2)
    assert [track.id for track in rest] == [1]
    assert [event.ids for event in rest.events] == [(1,)]
    assert len(rest.error) == rest.strokes.row_count == 4


def test_a_stroke_reversed_twice_is_itself_and_once_runs_backwards(tracks: StrokeTracks) -> None:
    once = tracks.reverse(1)
    np.testing.assert_allclose(once.follow(1, 0.25), tracks.follow(1, 0.75))
    np.testing.assert_array_equal(once.reverse(1).strokes.points, tracks.strokes.points)


def with_a_gap(tracks: StrokeTracks) -> StrokeTracks:
    """The first stroke alone, of which the third drawing shows both ends and not the middle; the second is its part."""
    whole = StrokeLife.of(tracks.strokes, 0)
    whole = replace(whole, visible=np.array([[0, 1], [0, 1], [0, 0.4], [0, 1.0]]))
    part = replace(whole.between(2, 2), id=5, visible=np.array([[0.6, 1.0]]), parent=1)
    return tracks_of([whole, part])


def test_material_beyond_a_gap_is_followed_through_the_part_that_shows_it(tracks: StrokeTracks) -> None:
    gap = with_a_gap(tracks)
    assert gap.parents == {5: 1}
    path = gap.follow(1, [0.25, 0.5, 0.75])[:, 4]
    np.testing.assert_allclose(path[[0, 2]], [[30, 24], [50, 24]], atol=1e-9)
    assert np.isnan(path[1]).all()


def test_a_part_beyond_a_gap_is_saved_as_one(tracks: StrokeTracks, tmp_path: Path) -> None:
    assert StrokeTracks.load(with_a_gap(tracks).save(tmp_path / "tracks.npz")).parents == {5: 1}


def test_edits_keep_a_part_beyond_a_gap_or_set_it_free(tracks: StrokeTracks) -> None:
    gap = with_a_gap(tracks)
    turned = gap.reverse(5)
    np.testing.assert_allclose(turned.follow(1, [0.25, 0.75]), gap.follow(1, [0.75, 0.25]))
    assert gap.rename(1, 9).parents == {5: 9}
    assert gap.split(1, frame=2).parents == {}
    assert gap.drop(1).parents == {}

"""The repeat of a brush, from strips that were laid along curves whose arc length is wrong."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from videovec.brush import Brush, BrushModel, Laying
from videovec.brush.drift import learn_texture, lie_along
from videovec.brush.lifts import find_lifts, part_strokes
from videovec.brush.partings import number_parts, parting_events, wholes_of
from videovec.brush.period import _first_good, find_repeat
from videovec.brush.refine import Laid
from videovec.brush.repeat import recurrence
from videovec.brush.shape import unfairness
from videovec.brush.strips import TEXELS_PER_WIDTH, Strip
from videovec.events import Event, EventKind
from videovec.strokes import Strokes

Floats = NDArray[np.float64]


def grain(widths: float, rng: np.random.Generator) -> Floats:
    """Rubbed ink, periodic in the first axis."""
    field = gaussian_filter(rng.normal(size=(round(widths * TEXELS_PER_WIDTH), 24)), (2.0, 1.2), mode="wrap")
    return np.asarray(field / field.std())


def laid(texture: Floats, widths: float, drift: float, rng: np.random.Generator) -> Strip:
    """A strip of a texture whose arc length is off by a share that varies along it, with as much noise as grain."""
    count = round(widths * TEXELS_PER_WIDTH)
    stretch = 1 + drift * (rng.uniform(-1, 1) + 8 * gaussian_filter1d(rng.normal(size=count), 60))
    place = np.cumsum(stretch) + rng.uniform(0, len(texture))
    left = np.floor(place).astype(int)
    share = (place - left)[:, None]
    ink = (1 - share) * texture[left % len(texture)] + share * texture[(left + 1) % len(texture)]
    ink = ink + grain(widths, rng)
    if rng.random() < 0.5:
        ink = ink[::-1, ::-1]
    return Strip(ink, np.ones_like(ink), np.ones(count), float("nan"))


def strip_turned(texture: Floats, strip: Strip) -> bool:
    """Whether a strip was laid from its end: its ink across follows that of the texture turned."""
    return lie_along(strip, texture, len(texture) / TEXELS_PER_WIDTH)[0] < 0


@pytest.mark.parametrize("widths", [7.0, 16.0])
def test_a_repeat_is_found_where_arc_lengths_drift(widths: float) -> None:
    rng = np.random.default_rng(int(widths))
    texture = grain(widths, rng)
    strips = [laid(texture, length, 0.02, rng) for length in rng.uniform(8, 48, 8)]
    found = recurrence(strips, 4.0, 40.0)
    assert found.peaks(1)[0] == pytest.approx(widths, rel=0.02)
    never = [laid(grain(200, rng), len(strip.grain) / TEXELS_PER_WIDTH, 0.02, rng) for strip in strips]
    assert found.score.max() > 2 * recurrence(never, 4.0, 40.0).score.max()
    assert find_repeat(strips, 4.0, 40.0) == pytest.approx(widths, rel=0.02)


def test_strokes_too_short_to_show_a_repeat_show_none() -> None:
    rng = np.random.default_rng(2)
    strips = [laid(grain(16.0, rng), 5.0, 0.0, rng) for _ in range(4)]
    assert not len(recurrence(strips, 4.0, 12.0).peaks(3))


def test_strokes_that_share_nothing_have_some_repeat_all_the_same() -> None:
    """Every score of evidence is below nothing: what explains no grain adds to it."""
    assert _first_good(np.array([-0.3, -0.1, -0.2])) == 1
    assert _first_good(np.array([0.2, 0.96, 1.0])) == 1


def test_a_stroke_is_parted_where_the_other_one_began_that_was_drawn_the_other_way() -> None:
    rng = np.random.default_rng(4)
    texture = grain(9.0, rng)
    strips = [laid(texture, length, 0.0, rng) for length in (30.0, 25.0, 20.0, 20.0)]
    first, second = laid(texture, 17.0, 0.0, rng), laid(texture, 14.0, 0.0, rng)
    second = second if (strip_turned(texture, first) != strip_turned(texture, second)) else second.turned()
    ink = np.concatenate([first.grain, second.grain])
    both = Strip(ink, np.ones_like(ink), np.ones(len(ink)), float("nan"))
    drawn = [*strips, both]
    for only_turned in (True, False):
        lifts = find_lifts(drawn, learn_texture(drawn, 9.0), only_turned)
        assert [len(lift) for lift in lifts] == [0, 0, 0, 0, 1]
        assert lifts[-1][0] == pytest.approx(17.0, abs=1.0)


@pytest.mark.parametrize("seed", range(4))
def test_no_stroke_is_parted_that_is_whole(seed: int) -> None:
    """Neither along a texture that arc lengths drift from, nor where grain is chance and the best place wins."""
    rng = np.random.default_rng(seed)
    texture, lengths = grain(9.0, rng), rng.uniform(12, 48, 8)
    for strips in (
        [laid(texture, one, 0.02, rng) for one in lengths],
        [laid(grain(60.0, rng), one, 0.0, rng) for one in lengths],
    ):
        assert [len(lift) for lift in find_lifts(strips, learn_texture(strips, 9.0))] == [0] * 8


def test_parting_keeps_the_curve() -> None:
    points = np.stack([np.arange(0.0, 130.0, 10.0), np.zeros(13)], axis=1)
    points[7:, 1] = 5 * np.arange(1.0, 7.0)  # a corner at the third joint
    strokes = Strokes.from_curves([points, points + 50.0], [np.arange(2.0, 7.0), np.full(5, 3.0)])
    brush = Brush("chalk", BrushModel.TEXTURE, np.full((108, 24), 0.5), 8.0, 9.0)
    parted = part_strokes(Laid(strokes, Laying.plain(strokes.layout), brush), [np.array([7.0]), np.zeros(0)])
    assert parted.strokes.ids.tolist() == [1, 3, 2]
    assert parted.strokes.layout.segments.tolist() == [2, 2, 4]
    joined = np.concatenate([parted.strokes.points_of(0), parted.strokes.points_of(1)[1:]])
    assert joined == pytest.approx(points)
    assert parted.strokes.half_width_of(1) == pytest.approx([4.0, 5.0, 6.0])
    assert len(parted.laying.phase) == 3 + 3 + 5


def test_even_segments_are_fair_at_any_size_and_folded_ones_are_not() -> None:
    straight = torch.tensor([[[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]], dtype=torch.float64)
    bent = straight.clone()
    bent[0, 1:3, 1] = 4.0
    folded = straight.clone()
    folded[0, 1, 0], folded[0, 2, 0] = 25.0, 5.0
    assert float(unfairness(straight)) == pytest.approx(0.0, abs=1e-12)
    assert float(unfairness(7 * bent)) == pytest.approx(float(unfairness(bent)))
    assert float(unfairness(folded)) > 20 * float(unfairness(bent))


def test_parts_have_identities_of_their_own_and_a_split_says_where_they_come_from() -> None:
    points = np.stack([np.arange(0.0, 130.0, 10.0), np.zeros(13)], axis=1)
    given = Strokes.from_curves([points, points + 50.0, points + 99.0], [np.full(5, 3.0)] * 3)
    first, other = given.select(np.array([True, True, False])), given.select(np.array([False, False, True]))
    brush = Brush("chalk", BrushModel.TEXTURE, np.full((108, 24), 0.5), 8.0, 9.0)
    lifts = [np.array([5.0, 10.0]), np.zeros(0)]
    parted = part_strokes(Laid(first, Laying.plain(first.layout), brush), lifts).strokes
    strokes = Strokes.concatenate([number_parts(parted, first, 3), other])
    assert strokes.ids.tolist() == [1, 4, 5, 2, 3]
    whole = wholes_of(strokes, given)
    assert whole.tolist() == [1, 1, 1, 2, 3]
    before = (Event(EventKind.DEATH, 7, (2,)), Event(EventKind.DEATH, 7, (1,)))
    support = np.array([1.0, 0.5, 0.9, 0.2, 0.2])
    split, *deaths = parting_events(strokes, whole, support, before)
    assert (split.kind, split.drawing, split.ids, split.parents) == (EventKind.SPLIT, 0, (1, 4, 5), (1,))
    assert split.score == pytest.approx(0.8)
    assert [event.ids for event in deaths] == [(1,), (2,), (4,), (5,)]
    assert parting_events(given, given.ids, np.ones(3), before[:1]) == before[:1]

"""The animated SVG, played by a reading of SMIL that is written here from its specification."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from drawn import coverage, psnr, resvg
from small_tracks import ROUND, SIZE, WAVE, life, tracks_of
from svgelements import Path

from videovec.settings import ExportSettings
from videovec.stroke_life import StrokeLife
from videovec.tracks import StrokeTracks
from videovec.write.animated_svg import animated_svg_text

NAME = "{http://www.w3.org/2000/svg}"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


@pytest.fixture
def tracks() -> StrokeTracks:
    """A tapering stroke, a ring born late, an ellipse of varying width, a line that is drawn on, hidden, and dies."""
    line = np.array([[10, 84], [30, 86], [60, 86], [86, 84.0]])
    lives = [
        _moving(life(1, WAVE, [1.5, 3.0, 2.0]), 6),
        replace(_moving(life(2, ROUND, [1.5] * 3, is_closed=True), 3), first=3),
        _moving(life(3, ROUND + 30, [1.0, 2.0, 1.0], is_closed=True), 6),
        _moving(life(4, line, [1, 1]), 5),
    ]
    view = np.array([[0, 0.2], [0, 0.6], [0.3, 0.3], [0.1, 1], [0.2, 0.9]])
    lives[-1] = replace(lives[-1], visible=view)
    return tracks_of(lives, exposures=(1, 2, 1, 1, 2, 1))


def _moving(plain: StrokeLife, count: int) -> StrokeLife:
    """A life of its first drawing's shape, moved evenly."""
    return replace(
        plain,
        points=plain.points[:1] + np.arange(count)[:, None, None] * np.array([0.7, -0.4]),
        half_width=np.repeat(plain.half_width[:1], count, axis=0),
        opacity=np.ones(count),
        visible=np.tile([0.0, 1.0], (count, 1)),
    )


def still(document: str, seconds: float) -> str:
    """What an animated document shows at a time, as a document that does not move."""
    root = ET.fromstring(document.encode())
    for path in root.iter(f"{NAME}path"):
        for animation in path.findall(f"{NAME}animate"):
            path.set(str(animation.get("attributeName")), _value(animation, seconds))
            path.remove(animation)
        if path.get("pathLength"):  # which resvg does not know: dashes are in units of the path's length over it
            unit = Path(path.get("d")).length() / float(str(path.get("pathLength")))
            for name in ("stroke-dasharray", "stroke-dashoffset"):
                lengths = [f"{float(each) * unit:.4f}" for each in str(path.get(name)).split()]
                path.set(name, " ".join(lengths))
    return ET.tostring(root, encoding="unicode")


def _value(animation: ET.Element, seconds: float) -> str:
    """SMIL 3.0, linear: between the last key time that is not later and the one after it, number by number."""
    duration = float(str(animation.get("dur")).removesuffix("s"))
    times = [float(time) for time in str(animation.get("keyTimes")).split(";")]
    values = str(animation.get("values")).split(";")
    assert len(times) == len(values)
    assert (times[0], times[-1]) == (0, 1)
    assert times == sorted(times)
    now = (seconds % duration) / duration
    k = max(k for k, time in enumerate(times) if time <= now)
    if k == len(times) - 1:
        return values[k]
    share = (now - times[k]) / (times[k + 1] - times[k])
    ends = iter(NUMBER.findall(values[k + 1]))
    assert NUMBER.sub("", values[k]) == NUMBER.sub("", values[k + 1])  # else players do not move between them
    return NUMBER.sub(lambda found: f"{(1 - share) * float(found[0]) + share * float(next(ends)):.5f}", values[k])


@pytest.mark.parametrize("frame", range(8))
def test_every_frame_shows_the_ink_of_its_strokes(tracks: StrokeTracks, frame: int) -> None:
    document = animated_svg_text(tracks, ExportSettings(lottie_tolerance=0.02))
    shapes = [shape for shape in tracks.at_frame(frame) if shape.is_visible]
    for moment in (0.01, 0.9) if frame in (1, 5) else (0.001,):  # the first frame of a hold does not move at all
        shown = resvg(still(document, (frame + moment) / 12), 4)
        assert psnr(shown, 1 - coverage(shapes, SIZE)) > 38


def test_a_stroke_has_its_name_and_no_script_is_needed(tracks: StrokeTracks) -> None:
    document = animated_svg_text(tracks, ExportSettings())
    names = [path.get("id") for path in ET.fromstring(document.encode()).iter(f"{NAME}path")]
    assert names == [f"stroke-{k:04d}" for k in (1, 2, 3, 4)]
    assert "script" not in document
    assert "style" not in document


def test_it_lasts_as_long_as_the_clip(tracks: StrokeTracks) -> None:
    ntsc = Fraction(1001, 30000)
    slow = replace(tracks.timeline, times=tuple(k * ntsc for k in range(8)), duration=8 * ntsc)
    document = animated_svg_text(replace(tracks, timeline=slow), ExportSettings())
    assert set(re.findall(r'dur="([\d.]+)s"', document)) == {"0.266933"}


def test_what_does_not_change_is_not_animated() -> None:
    rest = life(1, WAVE, [1.0] * 3)
    rest = replace(rest, points=np.stack([WAVE, WAVE]))
    assert "<animate" not in animated_svg_text(tracks_of([rest]), ExportSettings())

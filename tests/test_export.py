"""The folder of everything, and the pictures in it."""

from __future__ import annotations

import base64
import io
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from drawn import coverage
from PIL import Image
from small_tracks import ROUND, SIZE, WAVE, life, tracks_of

from videovec.clip import Clip
from videovec.errors import ConfigError
from videovec.events import Event, EventKind
from videovec.export import FORMATS, export
from videovec.strokes import Strokes
from videovec.tracks import StrokeTracks
from videovec.write.colours import identity_colours
from videovec.write.preview import contact_sheet, draw_identities
from videovec.write.report import FrameFigures, report_html
from videovec.write.style import is_constant_width, mean_half_widths
from videovec.write.video import preview_image, preview_video

UNEVEN = (Fraction(0), Fraction(1, 10), Fraction(1, 4))


@pytest.fixture
def tracks() -> StrokeTracks:
    plain = tracks_of([life(1, WAVE, [2.0, 3.0, 2.0]), life(2, ROUND, [1.5] * 3, is_closed=True)])
    return replace(plain, timeline=replace(plain.timeline, times=UNEVEN, duration=Fraction(1, 2)))


@pytest.fixture
def clip(tracks: StrokeTracks) -> Clip:
    drawings = tuple(
        np.repeat(np.rint(255 - 255 * coverage(tracks.at_frame(frame), SIZE)).astype(np.uint8)[..., None], 3, axis=2)
        for frame in (0, 1)
    )
    return Clip("test", drawings, tracks.timeline)


def test_a_folder_holds_a_file_of_every_format(tracks: StrokeTracks, clip: Clip, tmp_path: Path) -> None:
    written = export(tracks, clip, tmp_path / "out")
    names = {path.relative_to(tmp_path / "out").as_posix() for path in written}
    frames = {f"svg/frame_{k:04d}.svg" for k in (1, 2, 3)}
    assert names >= frames | {
        "clip.json",
        "clip.lottie",
        "clip.svg",
        "tracks.npz",
        "tracks.json",
        "preview.mp4",
        "report.html",
    }
    assert {path for path in (tmp_path / "out").rglob("*") if path.is_file()} == set(written)


def test_the_same_tracks_are_the_same_bytes_and_saved_ones_too(
    tracks: StrokeTracks, clip: Clip, tmp_path: Path
) -> None:
    first = export(tracks, clip, tmp_path / "a")
    again = export(StrokeTracks.load(tmp_path / "a" / "tracks.npz"), clip, tmp_path / "b")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]


def test_frames_that_are_gone_leave_the_folder(tracks: StrokeTracks, tmp_path: Path) -> None:
    export(tracks, None, tmp_path, formats=["svg"])
    shorter = replace(tracks, timeline=replace(tracks.timeline, frame_numbers=np.array([8, 9, 12])))
    export(shorter, None, tmp_path, formats=["svg"])
    assert sorted(path.name for path in (tmp_path / "svg").iterdir()) == [f"frame_00{k}.svg" for k in ("08", "09", 12)]


def test_an_unknown_format_is_refused_before_anything_is_written(tracks: StrokeTracks, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="unknown format lotti; did you mean 'lottie'"):
        export(tracks, None, tmp_path / "out", formats=["svg", "lotti"])
    assert not (tmp_path / "out").exists()
    assert "preview" in FORMATS


def test_the_preview_shows_every_frame_at_its_own_time(tracks: StrokeTracks, clip: Clip) -> None:
    with av.open(io.BytesIO(preview_video(tracks, clip)), "r") as container:
        stream = container.streams.video[0]
        frames = list(container.decode(stream))
        assert [frame.time for frame in frames] == pytest.approx([float(time) for time in UNEVEN])
        for k, frame in enumerate(frames):
            image = preview_image(tracks, clip, k)
            shown = frame.to_ndarray(format="rgb24")[: image.shape[0], : image.shape[1]]
            difference = shown.astype(float) - image
            assert np.abs(difference).mean() < 6


def test_the_source_stands_beside_its_strokes(tracks: StrokeTracks, clip: Clip) -> None:
    image = preview_image(tracks, clip, 0)
    half = (image.shape[1] - 4) // 2
    left, right = image[:, :half].min(2) < 128, image[:, -half:].min(2) < 128
    both = (left & right).sum() / (left | right).sum()
    assert both > 0.8
    assert preview_image(tracks, None, 0).shape[1] == half


def test_the_report_tells_what_each_frame_is_worth(tracks: StrokeTracks, clip: Clip) -> None:
    hurt = replace(tracks, name="a <b> & c", error=np.array([0.1, 0.3, 0.0, 0.4]))
    figures = FrameFigures.of(hurt, np.array([40.0, 31.5]))
    np.testing.assert_array_equal(figures.strokes, [2, 2, 2])
    np.testing.assert_array_equal(figures.worst, [1, 2, 2])
    np.testing.assert_allclose(figures.error, [np.sqrt(0.005), np.sqrt(0.125), np.sqrt(0.125)])
    hurt = replace(hurt, events=(Event(EventKind.SPLIT, 1, (1, 2), (9,), 0.5),))
    page = report_html(hurt, clip, np.array([40.0, 31.5]))
    assert "a &lt;b&gt; &amp; c" in page
    assert "PSNR 31.5 dB in the median, 31.5 dB at worst" in page
    assert "<td>2<td>split<td>1, 2<td>9<td>0.50" in page
    assert page.index("frame 2, 31.5 dB; the largest error lies under stroke 2") < page.index("frame 1, 40.0 dB")
    picture = Image.open(io.BytesIO(base64.b64decode(page.split("base64,")[1].split('"')[0])))
    np.testing.assert_array_equal(np.asarray(picture), preview_image(hurt, clip, 1))


def test_a_report_of_nothing_is_a_report(tracks: StrokeTracks) -> None:
    page = report_html(tracks.drop(1, 2), None, None)
    assert "0 strokes" in page
    assert "PSNR " not in page


def test_a_still_has_a_picture_too(tmp_path: Path) -> None:
    still = tracks_of([life(1, WAVE, [1.0] * 3)], exposures=(1, 1))
    timeline = replace(
        still.timeline, times=UNEVEN[:1], drawing_of_frame=np.zeros(1, int), frame_numbers=np.ones(1, int)
    )
    still = replace(
        still, timeline=timeline, strokes=still.strokes.at_drawing(0), error=np.zeros(1), confidence=np.ones(1)
    )
    written = export(still, None, tmp_path, formats=["preview"])
    assert [path.name for path in written] == ["preview.mp4", "preview.png"]
    with Image.open(tmp_path / "preview.png") as picture:
        assert picture.size == (5 * SIZE, 5 * SIZE)


def test_identities_have_colours_of_their_own_that_show_on_white() -> None:
    colours = identity_colours(np.arange(1, 60))
    assert colours.max(1).min() > 0.3
    luminance = colours @ [0.2126, 0.7152, 0.0722]
    assert luminance.max() < 0.8
    near = np.linalg.norm(colours[:, None] - colours[None], axis=-1) + 9 * np.eye(59)
    assert min(near[k, k + 1] for k in range(58)) > 0.3
    np.testing.assert_allclose(identity_colours([7]), colours[6:7])


def test_strokes_are_drawn_where_they_are_in_the_colour_of_their_identity(tracks: StrokeTracks) -> None:
    image = draw_identities(tracks, 0, scale=2)
    assert image.shape == (2 * SIZE, 2 * SIZE, 3)
    place = np.round(2 * tracks.follow(2, 0.25)[0]).astype(int)
    np.testing.assert_allclose(image[place[1], place[0]] / 255, identity_colours([2])[0], atol=0.01)
    ink = (image.min(2) < 128).reshape(SIZE, 2, SIZE, 2).mean((1, 3))
    assert np.abs(ink - coverage(tracks.at_frame(0), SIZE)).mean() < 0.02


def test_a_contact_sheet_has_room_for_the_largest_picture() -> None:
    pictures = [np.zeros((4, 6), np.uint8), np.full((8, 3, 3), 9, np.uint8), np.zeros((2, 2, 3), np.uint8)]
    sheet = contact_sheet(pictures, columns=2, gap=1)
    assert sheet.shape == (2 * 9 - 1, 2 * 7 - 1, 3)
    assert (sheet[:8, 7:10] == 9).all()
    assert (sheet[:8, 6] == 200).all()


@pytest.mark.parametrize("hidden", [True, False])
def test_widths_that_are_never_seen_do_not_make_a_line_an_outline(hidden: bool) -> None:
    """The second half of a stroke is twice as wide; by closed form, the mean of what is seen is that of the first."""
    points = np.stack([np.linspace(0, 90, 10), np.zeros(10)], axis=1)
    wide = Strokes.from_curves([points], [np.array([2.0, 2.0, 4.0, 4.0])])
    seen = replace(wide, visible=np.array([[0.0, 1 / 3 if hidden else 1.0]]))
    assert is_constant_width(seen, 0.1).tolist() == [hidden]
    assert mean_half_widths(seen) == pytest.approx([2.0 if hidden else 3.0])

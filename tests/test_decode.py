"""Decoding: what was written is read back, at the times at which it was written."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import imageio.v3 as iio
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from videovec.clip import Clip
from videovec.decode import decode
from videovec.decode_frame import broadcast_rate
from videovec.decode_video import on_exact_rate
from videovec.errors import InputError
from videovec.settings import DecodeSettings

Pixels = NDArray[np.uint8]


def bar(position: int, size: tuple[int, int] = (48, 64), ink: int = 0) -> Pixels:
    """White, with a black bar of 4 px at a position. [H, W, 3]"""
    image = np.full((*size, 3), 255, np.uint8)
    image[8:-8, position : position + 4] = ink
    return image


def bars(count: int, size: tuple[int, int] = (48, 64)) -> list[Pixels]:
    return [bar(6 + 6 * k, size) for k in range(count)]


def write_video(
    path: Path,
    images: Sequence[Pixels],
    codec: str = "ffv1",
    pixel_format: str = "bgr0",
    rate: Fraction = Fraction(24),
    ticks: Sequence[int] | None = None,
    time_base: Fraction | None = None,
) -> Path:
    """Write frames with their own times, in ticks of a time base, where given."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=rate)
        stream.height, stream.width = images[0].shape[:2]
        stream.pix_fmt = pixel_format
        stream.thread_count = 1
        if time_base is not None:
            stream.time_base = stream.codec_context.time_base = time_base
        for index, image in enumerate(images):
            frame = av.VideoFrame.from_ndarray(image, format="rgba" if image.shape[2] == 4 else "rgb24")
            if ticks is not None and time_base is not None:
                frame.pts, frame.time_base = ticks[index], time_base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


class Notes:
    """A progress that remembers what it was told."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.advanced = 0

    def stage(self, name: str, total: int) -> None:
        self.texts.append(f"{name} {total}")

    def advance(self, count: int = 1) -> None:
        self.advanced += count

    def note(self, text: str) -> None:
        self.texts.append(text)


def shows(clip: Clip, images: Sequence[Pixels], tolerance: int = 0) -> bool:
    """Whether every frame shows its image."""
    drawings = [clip.drawings[drawing] for drawing in clip.timeline.drawing_of_frame]
    return len(drawings) == len(images) and all(
        np.abs(drawing.astype(int) - image[..., :3]).max() <= tolerance
        for drawing, image in zip(drawings, images, strict=True)
    )


# Video


@pytest.mark.parametrize(
    ("name", "codec", "pixel_format", "tolerance"),
    [
        ("a.mkv", "ffv1", "bgr0", 0),
        ("a.mov", "png", "rgb24", 0),
        ("a.avi", "ffv1", "bgr0", 0),
        ("a.mp4", "libx264rgb", "rgb24", 12),
        ("a.mp4", "libx264", "yuv420p", 12),
        ("a.webm", "libvpx-vp9", "yuv420p", 24),
    ],
)
def test_every_container_gives_back_its_frames(
    tmp_path: Path, name: str, codec: str, pixel_format: str, tolerance: int
) -> None:
    images = bars(7)
    clip = decode(write_video(tmp_path / name, images, codec, pixel_format))
    assert shows(clip, images, tolerance)
    assert clip.name == "a"
    assert clip.timeline.frame_numbers.tolist() == [1, 2, 3, 4, 5, 6, 7]


@pytest.mark.parametrize("rate", [Fraction(24000, 1001), Fraction(30000, 1001), Fraction(25), Fraction(60)])
@pytest.mark.parametrize("name", ["a.mkv", "a.mp4", "a.mov", "a.avi"])
def test_constant_rates_are_exact_even_where_the_container_counts_milliseconds(
    tmp_path: Path, name: str, rate: Fraction
) -> None:
    codecs = {"a.mp4": ("libx264rgb", "rgb24"), "a.mov": ("png", "rgb24")}
    codec, pixel_format = codecs.get(name, ("ffv1", "bgr0"))
    clip = decode(write_video(tmp_path / name, bars(8), codec, pixel_format, rate))
    assert clip.timeline.times == tuple(k / rate for k in range(8))
    assert clip.timeline.duration == 8 / rate
    assert clip.timeline.frame_rate == rate


def test_variable_rates_keep_their_own_times(tmp_path: Path) -> None:
    ticks = [0, 1000, 1500, 4000, 4321]
    path = write_video(tmp_path / "a.mp4", bars(5), "libx264rgb", "rgb24", Fraction(24), ticks, Fraction(1, 12000))
    assert decode(path).timeline.times == tuple(Fraction(tick, 12000) for tick in ticks)


def test_times_on_a_coarse_clock_are_left_alone_unless_all_fit_one_rate() -> None:
    film, tick = Fraction(24000, 1001), Fraction(1, 1000)
    rounded = [Fraction(round(k / film * 1000), 1000) for k in (0, 1, 2, 5, 6)]
    assert on_exact_rate(rounded, film, tick) == [k / film for k in (0, 1, 2, 5, 6)]
    bent = [*rounded[:-1], rounded[-1] + Fraction(7, 1000)]
    assert on_exact_rate(bent, film, tick) == bent
    assert on_exact_rate(rounded, None, tick) == rounded


@pytest.mark.parametrize(
    ("given", "exact"),
    [
        (23.976, Fraction(24000, 1001)),
        (29.97, Fraction(30000, 1001)),
        (59.94, Fraction(60000, 1001)),
        (24.0, Fraction(24)),
        (12.5, Fraction(25, 2)),
    ],
)
def test_rounded_broadcast_rates_stand_for_exact_fractions(given: float, exact: Fraction) -> None:
    assert broadcast_rate(given) == exact


@pytest.mark.parametrize(("name", "codec"), [("a.webm", "libvpx-vp9"), ("a.mov", "png")])
def test_transparent_video_is_composited_on_white(tmp_path: Path, name: str, codec: str) -> None:
    images = []
    for image in bars(4):
        alpha = np.where(image[..., :1] == 0, 255, 0).astype(np.uint8)
        images.append(np.concatenate([np.zeros_like(image), alpha], axis=2))
    clip = decode(write_video(tmp_path / name, images, codec, "yuva420p" if name == "a.webm" else "rgba"))
    assert shows(clip, bars(4), 40 if name == "a.webm" else 0)


def test_ten_bit_video_keeps_more_than_eight_bits(tmp_path: Path) -> None:
    path = tmp_path / "a.mkv"
    ramp = np.linspace(0, 65535, 64 * 64).reshape(64, 64).astype(np.uint16)
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("ffv1", rate=24)
        stream.width, stream.height, stream.pix_fmt = 64, 64, "gray16le"
        container.mux(stream.encode(av.VideoFrame.from_ndarray(ramp, format="gray16le")))
        container.mux(stream.encode(None))
    drawing = decode(path).drawings[0]
    assert drawing.dtype == np.uint16
    assert np.abs(drawing[..., 1].astype(int) - ramp).max() <= 257


def test_a_truncated_video_gives_the_frames_that_decode_and_says_so(tmp_path: Path) -> None:
    whole = write_video(tmp_path / "whole.mkv", bars(8)).read_bytes()
    (tmp_path / "cut.mkv").write_bytes(whole[: len(whole) * 6 // 10])
    notes = Notes()
    clip = decode(tmp_path / "cut.mkv", progress=notes)
    assert 1 <= clip.timeline.frame_count < 8
    assert any("damaged or cut short" in text for text in notes.texts)
    assert shows(clip, bars(8)[: clip.timeline.frame_count])


# Animated images


@pytest.mark.parametrize(
    ("name", "delays"), [("a.gif", [40, 70, 100, 20]), ("a.png", [41, 70, 100, 7]), ("a.webp", [41, 70, 100, 7])]
)
def test_animated_images_keep_their_delays_and_pixels(tmp_path: Path, name: str, delays: list[int]) -> None:
    images = bars(4, (49, 65))
    frames = [Image.fromarray(image) for image in images]
    options: dict[str, Any] = {"lossless": True} if name.endswith("webp") else {}
    frames[0].save(tmp_path / name, save_all=True, append_images=frames[1:], duration=delays, loop=0, **options)
    clip = decode(tmp_path / name)
    assert shows(clip, images)
    assert clip.timeline.times == tuple(Fraction(sum(delays[:k]), 1000) for k in range(4))
    assert clip.timeline.duration == Fraction(sum(delays), 1000)


def test_a_transparent_gif_is_composited_on_white(tmp_path: Path) -> None:
    frames = [
        Image.fromarray(np.dstack([np.zeros((32, 32, 3), np.uint8), 255 - bar(4 + 6 * k, (32, 32))[..., 0]]), "RGBA")
        for k in range(3)
    ]
    frames[0].save(tmp_path / "a.gif", save_all=True, append_images=frames[1:], duration=50, disposal=2)
    assert shows(decode(tmp_path / "a.gif"), [bar(4 + 6 * k, (32, 32)) for k in range(3)])


def test_a_truncated_gif_gives_the_frames_that_decode_and_says_so(tmp_path: Path) -> None:
    frames = [Image.fromarray(image) for image in bars(8)]
    frames[0].save(tmp_path / "whole.gif", save_all=True, append_images=frames[1:], duration=50)
    whole = (tmp_path / "whole.gif").read_bytes()
    (tmp_path / "cut.gif").write_bytes(whole[: len(whole) * 2 // 3])
    notes = Notes()
    clip = decode(tmp_path / "cut.gif", progress=notes)
    assert 1 <= clip.timeline.frame_count < 8
    assert any("damaged or cut short" in text for text in notes.texts)
    assert shows(clip, bars(8)[: clip.timeline.frame_count])


# Stills and sequences


@pytest.mark.parametrize("suffix", ["png", "bmp", "tif", "jpg"])
def test_a_single_image_is_a_clip_of_one_frame(tmp_path: Path, suffix: str) -> None:
    iio.imwrite(tmp_path / f"a.{suffix}", bar(20))
    clip = decode(tmp_path / f"a.{suffix}")
    assert shows(clip, [bar(20)], 8 if suffix == "jpg" else 0)
    assert clip.timeline.times == (Fraction(0),)
    assert clip.timeline.frame_rate == 1


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "CMYK"])
def test_every_pixel_type_gives_the_same_colours(tmp_path: Path, mode: str) -> None:
    path = tmp_path / ("a.tif" if mode == "CMYK" else "a.png")
    Image.fromarray(bar(20)).convert(mode).save(path)
    assert shows(decode(path), [bar(20)])


def test_half_transparent_black_on_white_is_grey(tmp_path: Path) -> None:
    image = np.zeros((16, 16, 4), np.uint8)
    image[..., 3] = 64
    iio.imwrite(tmp_path / "a.png", image)
    assert np.all(decode(tmp_path / "a.png").drawings[0] == 191)


def test_a_palette_with_a_transparent_entry_is_composited(tmp_path: Path) -> None:
    image = Image.new("P", (16, 16), 0)
    image.putpalette([200, 0, 0, 0, 0, 255])
    image.paste(1, (4, 4, 8, 8))
    image.save(tmp_path / "a.png", transparency=0)
    drawing = decode(tmp_path / "a.png").drawings[0]
    assert drawing[0, 0].tolist() == [255, 255, 255]
    assert drawing[5, 5].tolist() == [0, 0, 255]


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_sixteen_bits_survive(tmp_path: Path, suffix: str, channels: int) -> None:
    import cv2

    ramp = np.linspace(0, 65535, 24 * 20 * channels).reshape(24, 20, channels).astype(np.uint16)
    if channels == 4:
        ramp[..., 3] = 65535
    cv2.imwrite(str(tmp_path / f"a.{suffix}"), ramp)
    drawing = decode(tmp_path / f"a.{suffix}").drawings[0]
    assert drawing.dtype == np.uint16
    assert np.array_equal(drawing, np.broadcast_to(ramp if channels == 1 else ramp[..., 2::-1], drawing.shape))


def test_exif_orientation_is_honoured(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(bar(4, (24, 40))).save(tmp_path / "a.jpg", exif=exif, quality=95)
    assert decode(tmp_path / "a.jpg").size == (40, 24)


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path: Path) -> None:
    images = bars(11, (33, 71))
    for number, image in enumerate(images, start=1):
        iio.imwrite(tmp_path / f"walk_{number}.png", image)
    iio.imwrite(tmp_path / "thumbnail.png", bar(3))
    (tmp_path / "notes.txt").write_text("not an image")
    notes = Notes()
    clip = decode(tmp_path, DecodeSettings(frame_rate=29.97), progress=notes)
    assert shows(clip, images)
    assert clip.timeline.frame_rate == Fraction(30000, 1001)
    assert clip.name == tmp_path.name
    assert any("1 other images left out" in text for text in notes.texts)


@pytest.mark.parametrize(("pattern", "name"), [("walk_%04d.png", "walk"), ("walk_%d.png", "walk")])
def test_a_pattern_reads_the_files_that_match(tmp_path: Path, pattern: str, name: str) -> None:
    for number in range(9, 12):
        iio.imwrite(tmp_path / f"walk_{number:04d}.png", bar(number))
        iio.imwrite(tmp_path / f"run_{number:04d}.png", bar(30))
    clip = decode(tmp_path / pattern)
    assert shows(clip, [bar(9), bar(10), bar(11)])
    assert clip.name == name


# Selection


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        (slice(2, 5), [2, 3, 4]),
        (slice(None, 3), [0, 1, 2]),
        (slice(-3, None), [6, 7, 8]),
        (slice(1, -6), [1, 2]),
        (slice(None, None, 3), [0, 3, 6]),
        (slice(4, 400), [4, 5, 6, 7, 8]),
    ],
)
def test_frames_are_chosen_as_python_does(tmp_path: Path, chosen: slice, expected: list[int]) -> None:
    images = [bar(2 + 5 * k) for k in range(9)]
    notes = Notes()
    clip = decode(write_video(tmp_path / "a.mkv", images), frames=chosen, progress=notes)
    assert shows(clip, [images[k] for k in expected])
    assert clip.timeline.frame_numbers.tolist() == [k + 1 for k in expected]
    assert clip.timeline.times == tuple(Fraction(k - expected[0], 24) for k in expected)
    assert clip.timeline.duration == Fraction(expected[-1] - expected[0] + (chosen.step or 1), 24)
    assert notes.advanced == len(expected)


# Holds


def test_equal_frames_are_one_drawing_with_an_exposure(tmp_path: Path) -> None:
    exposures = [2, 1, 3, 2]
    images = [bar(6 + 8 * k) for k, count in enumerate(exposures) for _ in range(count)]
    clip = decode(write_video(tmp_path / "a.mkv", images))
    assert clip.timeline.drawing_of_frame.tolist() == [0, 0, 1, 2, 2, 2, 3, 3]
    assert len(clip.drawings) == 4


def lines(shift: float, width: float = 1.0) -> Pixels:
    """Slanted lines of any width, exact along each row, moved to the right. [96, 96, 3]"""
    y, x = np.mgrid[0:96, 0:96]
    image = np.full((96, 96), 255.0)
    for start in (20, 45, 70):
        left = start + shift + 0.1 * (y - 48) - width / 2
        image -= 255 * np.clip(np.minimum(x + 1, left + width) - np.maximum(x, left), 0, 1)
    return np.repeat(np.rint(image).astype(np.uint8)[..., None], 3, axis=2)


@pytest.mark.parametrize("crf", [12, 18, 23, 28])
@pytest.mark.parametrize("width", [0.5, 1.0, 3.0])
def test_compression_noise_does_not_split_holds_and_small_motion_does(tmp_path: Path, crf: int, width: float) -> None:
    images = [lines(0.3 * (k // 3), width) for k in range(9)]
    path = tmp_path / "a.mp4"
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("libx264", rate=24, options={"crf": str(crf)})
        stream.width, stream.height, stream.pix_fmt, stream.thread_count = 96, 96, "yuv420p", 1
        for image in images:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    assert decode(path).timeline.drawing_of_frame.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]


@pytest.mark.parametrize("sigma", [2.0, 5.0])
def test_grain_does_not_split_holds_and_their_mean_is_less_noisy(tmp_path: Path, sigma: float) -> None:
    generator = np.random.default_rng(3)
    for k in range(8):
        clean = lines(2.0 * (k // 4), 2.0) * 0.8 + 25.0
        noisy = clean + generator.normal(0, sigma, clean.shape)
        iio.imwrite(tmp_path / f"a_{k}.png", np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    clip = decode(tmp_path)
    assert clip.timeline.drawing_of_frame.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    error = clip.drawings[0] - (lines(0.0, 2.0) * 0.8 + 25.0)
    assert float(np.sqrt(np.mean(error**2))) < 0.65 * sigma


def test_a_small_stroke_that_appears_is_a_new_drawing(tmp_path: Path) -> None:
    images = [lines(0.0), lines(0.0), lines(0.0).copy()]
    images[2][50, 5:11] = 170
    clip = decode(write_video(tmp_path / "a.mkv", images))
    assert clip.timeline.drawing_of_frame.tolist() == [0, 0, 1]


def test_a_faint_stroke_that_appears_in_clean_art_is_a_new_drawing(tmp_path: Path) -> None:
    images = [lines(0.0), lines(0.0).copy()]
    images[1][30:60, 35:37] = 240
    clip = decode(write_video(tmp_path / "a.mkv", images))
    assert clip.timeline.drawing_of_frame.tolist() == [0, 1]


def test_slow_motion_does_not_creep_through_a_hold(tmp_path: Path) -> None:
    for k in range(12):
        iio.imwrite(tmp_path / f"a_{k:02d}.png", lines(0.1 * k))
    clip = decode(tmp_path)
    assert len(clip.drawings) == 12


@pytest.mark.parametrize("name", ["robot.mp4", "ball.gif", "cat", "snail.png"])
def test_our_samples_have_the_drawings_that_they_were_made_of(name: str) -> None:
    samples = Path(__file__).parent.parent / "samples"
    truth = json.loads((samples / "truth" / f"{name.split('.')[0]}.json").read_text())
    clip = decode(samples / name)
    assert clip.timeline.drawing_of_frame.tolist() == truth["drawing_of_frame"]
    assert list(clip.size) == truth["size"][::-1]
    if len(clip.drawings) > 1:
        assert clip.timeline.frame_rate == truth["frame_rate"]


# Errors: one line that names the thing, what it must be and what it got


def write_bytes(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def broken(tmp_path: Path, kind: str) -> Path:
    """Something that cannot be used."""
    path = tmp_path / "thing"
    if kind == "missing":
        return path
    if kind == "no images":
        path.mkdir()
        (path / "readme.txt").write_text("no pictures here")
        return path
    if kind == "mixed sizes":
        path.mkdir()
        iio.imwrite(path / "a_1.png", bar(4))
        iio.imwrite(path / "a_2.png", bar(4, (40, 40)))
        return path
    if kind == "no match":
        return tmp_path / "walk_%04d.png"
    if kind == "tiny":
        iio.imwrite(tmp_path / "tiny.png", np.zeros((1, 1, 3), np.uint8))
        return tmp_path / "tiny.png"
    if kind == "cut image":
        iio.imwrite(tmp_path / "whole.png", np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8))
        return write_bytes(tmp_path / "cut.png", (tmp_path / "whole.png").read_bytes()[:400])
    if kind == "cut video":
        whole = write_video(tmp_path / "whole.mp4", bars(4), "libx264rgb", "rgb24").read_bytes()
        return write_bytes(tmp_path / "cut.mp4", whole[: len(whole) // 2])
    contents = {
        "empty": b"",
        "text": b"This is only a text.\n" * 50,
        "noise": np.random.default_rng(1).integers(0, 255, 5000, np.uint8).tobytes(),
    }
    return write_bytes(tmp_path / ("a.txt" if kind == "text" else "a.mp4"), contents[kind])


@pytest.mark.parametrize(
    ("kind", "got"),
    [
        ("missing", "got nothing there"),
        ("empty", "got an empty file"),
        ("no images", "got one without any image"),
        ("mixed sizes", "got 40 x 40"),
        ("no match", "got none"),
        ("tiny", "got 1 x 1"),
        ("cut image", "got a damaged"),
        ("cut video", "FFmpeg cannot open"),
        ("text", "got neither"),
        ("noise", "FFmpeg cannot open"),
    ],
)
def test_what_cannot_be_used_is_named_in_one_line(tmp_path: Path, kind: str, got: str) -> None:
    path = broken(tmp_path, kind)
    with pytest.raises(InputError) as raised:
        decode(path)
    message = str(raised.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    assert "must" in message
    assert got in message


def test_choosing_no_frame_is_an_error_that_says_how_many_there_are(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mkv", bars(4))
    with pytest.raises(InputError, match=r"frames 8:9 must select at least one frame, got none of 4"):
        decode(path, frames=slice(7, 9))
    with pytest.raises(InputError, match="step between frames"):
        decode(path, frames=slice(None, None, -1))

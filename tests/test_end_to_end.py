"""The main job on every kind of input and with every pipeline, on clips that are drawn here."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import imageio.v3 as iio
import numpy as np
import pytest
import resvg_py
from numpy.typing import NDArray
from PIL import Image

import videovec
from videovec.tracks import StrokeTracks

Frames = NDArray[np.uint8]
PIPELINES = sorted(path.stem for path in (Path(__file__).parents[1] / "pipelines").glob("[!_]*.py"))
SIDE = 64


def draw_frames(count: int = 4) -> Frames:
    """A ring that drifts and a bar that tilts, 3 px wide, on white; box-filtered from 8 x 8 samples. [T, H, W, 3]"""
    fine = 8
    y, x = (np.mgrid[: SIDE * fine, : SIDE * fine] + 0.5) / fine
    frames = []
    for frame in range(count):
        ring = np.abs(np.hypot(x - 20 - frame, y - 22) - 11)
        angle = 0.3 + 0.08 * frame
        along = (x - 42) * np.cos(angle) + (y - 42) * np.sin(angle)
        across = (y - 42) * np.cos(angle) - (x - 42) * np.sin(angle)
        bar = np.hypot(np.maximum(np.abs(along) - 15, 0), across)
        ink = np.minimum(ring, bar) < 1.5
        coverage = ink.reshape(SIDE, fine, SIDE, fine).mean((1, 3))
        frames.append(np.repeat((255 * (1 - coverage)).round().astype(np.uint8)[..., None], 3, axis=2))
    return np.stack(frames)


def write_video(path: Path, frames: Frames, codec: str, pixels: str) -> None:
    """Code frames with PyAV at 12 frames per second."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(12))
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height, stream.pix_fmt = SIDE, SIDE, pixels
        if codec == "libx264":
            stream.options = {"crf": "10"}
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, "rgb24")))
        container.mux(stream.encode(None))


def video(name: str, codec: str, pixels: str = "yuv420p") -> Callable[[Path, Frames], Path]:
    """Something that writes a video of one kind."""

    def write(folder: Path, frames: Frames) -> Path:
        write_video(folder / name, frames, codec, pixels)
        return folder / name

    return write


def animation(name: str, file_format: str | None = None) -> Callable[[Path, Frames], Path]:
    """Something that writes an animated image of one kind."""

    def write(folder: Path, frames: Frames) -> Path:
        first, *rest = (Image.fromarray(frame) for frame in frames)
        first.save(folder / name, save_all=True, append_images=rest, duration=80, loop=0, format=file_format)
        return folder / name

    return write


def images(returned: str) -> Callable[[Path, Frames], Path]:
    """Something that writes numbered images and names them by folder or by pattern."""

    def write(folder: Path, frames: Frames) -> Path:
        (folder / "walk").mkdir()
        for number, frame in enumerate(frames, start=1):
            iio.imwrite(folder / "walk" / f"walk_{number:04d}.png", frame)
        return folder / returned

    return write


def still(folder: Path, frames: Frames) -> Path:
    """Write one image."""
    iio.imwrite(folder / "still.png", frames[0])
    return folder / "still.png"


KINDS = {
    "mp4": video("clip.mp4", "libx264"),
    "mov": video("clip.mov", "libx264"),
    "mkv": video("clip.mkv", "libx264"),
    "webm": video("clip.webm", "libvpx-vp9"),
    "avi": video("clip.avi", "mjpeg", "yuvj420p"),
    "gif": animation("clip.gif"),
    "apng": animation("clip.apng", file_format="PNG"),
    "webp": animation("clip.webp"),
    "folder": images("walk"),
    "pattern": images("walk/walk_%04d.png"),
    "still": still,
}


def worst_psnr(folder: Path, frames: Frames) -> float:
    """How well our SVG, drawn by an independent rasteriser, shows the frames. dB"""
    worst = np.inf
    paths = sorted((folder / "svg").glob("frame_*.svg"))
    assert len(paths) == len(frames)
    for path, frame in zip(paths, frames, strict=True):
        png = bytes(resvg_py.svg_to_bytes(svg_path=str(path), background="white"))
        image = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), float)
        assert image.shape == frame.shape
        worst = min(worst, -10 * np.log10(np.mean((image - frame) ** 2) / 255**2))
    return float(worst)


def run(source: Path, folder: Path, *overrides: str) -> StrokeTracks:
    """Vectorise with fewer steps than usual."""
    quick = videovec.configure("preview", ["export.svg_style=outline", *overrides])
    return videovec.run(source, folder, config=quick)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_input_becomes_every_output(tmp_path: Path, kind: str) -> None:
    frames = draw_frames()
    source = KINDS[kind](tmp_path, frames)
    tracks = run(source, tmp_path / "out")
    shown = frames[:1] if kind == "still" else frames
    assert tracks.timeline.frame_count == len(shown)
    assert len(tracks.strokes) == 2
    outputs = {path.relative_to(tmp_path / "out").parts[0] for path in (tmp_path / "out").rglob("*")}
    assert outputs >= {"svg", "clip.json", "tracks.npz", "tracks.json", "preview.mp4", "run.json"}
    assert worst_psnr(tmp_path / "out", shown) > 25


@pytest.mark.parametrize("pipeline", PIPELINES)
def test_every_pipeline_keeps_the_identities_of_a_ring_and_a_bar(tmp_path: Path, pipeline: str) -> None:
    frames = draw_frames()
    source = images("walk")(tmp_path, frames)
    tracks = run(source, tmp_path / "out", f"pipeline={pipeline}")
    assert sorted(tracks.strokes.layout.last - tracks.strokes.layout.first + 1) == [4, 4]
    least = 26 if pipeline == "textured" else 28  # a soft cross profile is written as an even line of its mean density
    assert worst_psnr(tmp_path / "out", frames) > least


def test_an_artists_svg_gives_the_first_strokes_their_order_and_identity(tmp_path: Path) -> None:
    frames = draw_frames()
    source = images("walk")(tmp_path, frames)
    bar = [(42 + 15 * side * np.cos(0.3), 42 + 15 * side * np.sin(0.3)) for side in (1, -1)]
    (tmp_path / "first.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" fill="none" stroke="black">'
        f'<path data-stroke-id="5" stroke-width="3" d="M{bar[0][0]},{bar[0][1]} L{bar[1][0]},{bar[1][1]}"/>'
        '<circle data-stroke-id="9" stroke-width="3" cx="20" cy="22" r="11"/></svg>'
    )
    tracks = run(source, tmp_path / "out", f"initialise.reference={tmp_path / 'first.svg'}")
    assert tracks.strokes.ids.tolist() == [5, 9]
    right, left = tracks[5].at(3).points[[0, -1], 0]
    assert right > left
    assert worst_psnr(tmp_path / "out", frames) > 25


def test_what_an_artist_left_out_becomes_strokes_after_the_artists(tmp_path: Path) -> None:
    frames = draw_frames()
    source = images("walk")(tmp_path, frames)
    (tmp_path / "first.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" fill="none" stroke="black">'
        '<circle data-stroke-id="9" stroke-width="3" cx="20" cy="22" r="11"/></svg>'
    )
    tracks = run(source, tmp_path / "out", f"initialise.reference={tmp_path / 'first.svg'}")
    assert tracks.strokes.ids.tolist() == [9, 10]
    assert tracks[10].life == tracks[9].life
    assert not tracks.events
    assert worst_psnr(tmp_path / "out", frames) > 25


def test_the_same_input_and_seed_give_the_same_bytes(tmp_path: Path) -> None:
    source = images("walk")(tmp_path, draw_frames(3))
    written = []
    for name in ("a", "b"):
        run(source, tmp_path / name)
        files = sorted(path for path in (tmp_path / name).rglob("*") if path.is_file())
        written.append({path.relative_to(tmp_path / name): path.read_bytes() for path in files})
    timed = {Path("run.json")}
    assert written[0].keys() == written[1].keys()
    assert [path for path in written[0].keys() - timed if written[0][path] != written[1][path]] == []


def test_run_json_says_what_was_done(tmp_path: Path) -> None:
    run(still(tmp_path, draw_frames(1)), tmp_path / "out")
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["status"] == "done"
    assert record["config"]["fit"]["steps"] == 70
    assert record["versions"]["torch"]
    assert record["metrics"]["strokes"] == 2
    assert set(record["seconds"]) >= {"decode", "fit"}


@pytest.mark.parametrize("shape", [(1, 1), (2, 300), (64, 64)])
def test_a_blank_page_is_told_in_one_line(tmp_path: Path, shape: tuple[int, int]) -> None:
    iio.imwrite(tmp_path / "blank.png", np.full((*shape, 3), 255, np.uint8))
    with pytest.raises(videovec.UserError) as error:
        run(tmp_path / "blank.png", tmp_path / "out")
    assert "\n" not in str(error.value)


class Stages:
    """Keeps which stages there were."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def stage(self, name: str, total: int) -> None:
        self.names.append(name)

    def advance(self, count: int = 1) -> None:
        pass

    def note(self, text: str) -> None:
        pass


def test_a_still_is_fitted_once(tmp_path: Path) -> None:
    iio.imwrite(tmp_path / "still.png", draw_frames(1)[0])
    stages = Stages()
    tracks = videovec.track(tmp_path / "still.png", progress=stages)
    assert stages.names.count("fit") == 1
    assert len(tracks.strokes) == 2

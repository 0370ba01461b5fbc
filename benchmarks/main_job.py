"""The main job, whole: time, memory, fidelity of the SVG frames, flicker, and whether two runs write the same bytes.

    PYTHONPATH=. python benchmarks/main_job.py [CLIP ...] [--frames A:B] [--twice] [--lengths N ...]

Every clip is run by ``videovec run`` in a process of its own. The SVG frames (outline style) are drawn by resvg, an
independent rasteriser, and compared with the decoded source frames. ``--lengths`` does the same with a waving robot of
the samples over so many drawings, of equal motion each: does the cost grow linearly? Prints a table in Markdown.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import resvg_py
from numpy.typing import NDArray

from samples.cast import robot
from samples.scene import paint
from videovec.clip import Clip
from videovec.decode import decode
from videovec.settings import DecodeSettings
from videovec.tracks import StrokeTracks

VOLATILE = {"run.json"}
"""Files that hold times of day; all others must be the same bytes for the same input and seed."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table."""

    clip: str
    size: str
    drawings: int
    strokes: int
    median_psnr: float
    worst_psnr: float
    count_changes: int
    seconds: float
    processor: float
    megabytes: float
    lottie_kib: float
    is_same: str

    HEADER = (
        "| clip | size | drawings | strokes | PSNR median dB | PSNR worst dB | frames where the stroke count changes "
        "| s per drawing | processor s per drawing | peak MB | Lottie KiB | same bytes |\n" + 12 * "|---" + "|"
    )

    def __str__(self) -> str:
        return (
            f"| {self.clip} | {self.size} | {self.drawings} | {self.strokes} | {self.median_psnr:.1f} "
            f"| {self.worst_psnr:.1f} | {self.count_changes} | {self.seconds / self.drawings:.2f} "
            f"| {self.processor / self.drawings:.2f} | {self.megabytes:.0f} | {self.lottie_kib:.0f} | {self.is_same} |"
        )


def run_once(clip: str, out: Path, frames: str | None) -> tuple[float, float, float]:
    """Wall seconds, processor seconds and peak memory (MB) of one run from nothing."""
    command = [sys.executable, "-m", "videovec", "run", clip, "-o", str(out), "--svg-style", "outline", "--fresh", "-q"]
    begin = time.perf_counter()
    process = subprocess.Popen(command + (["--frames", frames] if frames else []))
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{clip}: videovec run ended with status {os.waitstatus_to_exitcode(status)}")
    return time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def write_waving_robot(folder: Path, count: int) -> str:
    """A robot that waves once in 20 drawings, as numbered images; their pattern."""
    for drawing in range(count):
        image = paint(robot(drawing / 20, 0.0, 0.0), (512, 512))
        iio.imwrite(folder / f"robot{count}_{drawing + 1:04d}.png", image)
    return str(folder / f"robot{count}_%04d.png")


def drawn_by_resvg(path: Path, page: NDArray[np.float64]) -> NDArray[np.uint8]:
    """An SVG frame as an independent rasteriser draws it. uint8 [H, W, 3]"""
    colour = "#" + "".join(f"{round(255 * c):02x}" for c in page)
    png = bytes(resvg_py.svg_to_bytes(svg_path=str(path), background=colour))
    return np.asarray(iio.imread(io.BytesIO(png), extension=".png")[..., :3])


def frame_psnr(clip: Clip, tracks: StrokeTracks, folder: Path) -> list[float]:
    """PSNR of every SVG frame against its source frame. dB"""
    values = []
    for frame, drawing in enumerate(clip.timeline.drawing_of_frame.tolist()):
        source = clip.drawings[drawing].astype(float)
        source = source / (65535 if clip.drawings[drawing].dtype == np.uint16 else 255)
        drawn = drawn_by_resvg(folder / "svg" / f"frame_{frame + 1:04d}.svg", tracks.page).astype(float) / 255
        values.append(float(-10 * np.log10(max(np.mean((source - drawn) ** 2), 1e-10))))
    return values


def digest(folder: Path) -> str:
    """One hash of all files that must not change between two runs."""
    whole = hashlib.sha256()
    for path in sorted(p for p in folder.rglob("*") if p.is_file() and p.name not in VOLATILE):
        whole.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return whole.hexdigest()


def measure(source: str, frames: str | None, twice: bool) -> Row:
    """Run a clip and measure what came out."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "first"
        seconds, processor, megabytes = run_once(source, folder, frames)
        is_same = "not tried"
        if twice:
            run_once(source, Path(scratch) / "second", frames)
            is_same = "yes" if digest(folder) == digest(Path(scratch) / "second") else "NO"
        clip = decode(source, DecodeSettings(), frames)
        tracks = StrokeTracks.load(folder / "tracks.npz")
        values = frame_psnr(clip, tracks, folder)
        visible = tracks.strokes.visible[:, 1] > tracks.strokes.visible[:, 0]
        count = np.bincount(tracks.strokes.layout.row_drawing[visible], minlength=clip.timeline.drawing_count)
        return Row(
            clip=clip.name,
            size=f"{clip.size[1]} x {clip.size[0]}",
            drawings=clip.timeline.drawing_count,
            strokes=len(tracks.strokes),
            median_psnr=float(np.median(values)),
            worst_psnr=min(values),
            count_changes=int(np.count_nonzero(np.diff(count))),
            seconds=seconds,
            processor=processor,
            megabytes=megabytes,
            lottie_kib=(folder / "clip.json").stat().st_size / 1024,
            is_same=is_same,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", nargs="*", metavar="CLIP")
    parser.add_argument("--frames", help="frames A:B of each clip, both included")
    parser.add_argument("--twice", action="store_true", help="run again and compare bytes")
    parser.add_argument("--lengths", type=int, nargs="+", default=[], help="drawings of the waving robot")
    arguments = parser.parse_args()
    print(Row.HEADER)
    for clip in arguments.clips:
        print(measure(clip, arguments.frames, arguments.twice), flush=True)
    for count in arguments.lengths:
        with tempfile.TemporaryDirectory() as folder:
            print(measure(write_waving_robot(Path(folder), count), None, arguments.twice), flush=True)


if __name__ == "__main__":
    main()

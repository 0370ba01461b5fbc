"""A file, folder or pattern becomes a clip: its drawings, and exactly when each is shown."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import Any, cast

import numpy as np

from videovec.clip import Clip, Image, Timeline
from videovec.decode_frame import FrameSource, Pixels, SourceFrame, broadcast_rate
from videovec.decode_holds import HoldMerger
from videovec.decode_images import (
    AnimationSource,
    SequenceSource,
    files_of_folder,
    files_of_pattern,
    image_frame_count,
)
from videovec.decode_video import VideoSource, on_exact_rate
from videovec.errors import InputError
from videovec.progress import Progress, Silent
from videovec.settings import DecodeSettings

__all__ = ["decode", "open_source"]

STILL_DURATION = Fraction(1)
"""How long a single image is shown. Seconds"""


def decode(
    path: Path | str,
    settings: DecodeSettings | None = None,
    frames: slice | None = None,
    progress: Progress | None = None,
) -> Clip:
    """Read a clip and merge its holds.

    Args:
        path: A video, an animated or single image, a folder of numbered images, or a pattern such as
            ``walk_%04d.png``.
        settings: How; the defaults if none.
        frames: Which frames, counted from 0 and half-open as in Python; negative numbers count from the end.
        progress: Told of every frame, and of damage.

    Returns:
        One image per drawing and the times of all frames, from 0.

    Raises:
        InputError: There is nothing there that can be used; the message names it in one line.
    """
    settings, progress = settings or DecodeSettings(), progress or Silent()
    path, chosen = Path(path), frames or slice(None)
    source = open_source(path, settings, progress)
    progress.stage("decode", len(range(*chosen.indices(source.frame_count))) if (chosen.step or 1) > 0 else 0)
    merger = HoldMerger(settings.hold_tolerance)
    numbers, drawing_of_frame, spans = [], [], []
    for number, frame in _select(source, chosen, path):
        drawing_of_frame.append(merger.add(frame.image))
        numbers.append(number)
        spans.append((frame.time, frame.duration))
        progress.advance()
    merger.finish()
    if not numbers:
        raise InputError(f"{path}: frames {_told(chosen)} must select at least one frame, got none of {_count(source)}")
    times, duration = _exact_times(spans, source)
    timeline = Timeline(np.array(drawing_of_frame, np.intp), times, duration, np.array(numbers, np.intp))
    return Clip(_name(path), cast(tuple[Image, ...], tuple(merger.drawings)), timeline)


def _told(chosen: slice) -> str:
    """A choice of frames as the command line says it: A:B, both included and counted from 1."""
    start, stop = chosen.start, chosen.stop
    first = "" if start is None else str(start + (start >= 0))
    last = "" if stop is None else str(stop - (stop < 0))
    return f"{first}:{last}"


def open_source(path: Path, settings: DecodeSettings, progress: Progress) -> FrameSource:
    """Find out what a path is.

    Raises:
        InputError: Nothing that frames can come from.
    """
    frame_duration = 1 / broadcast_rate(settings.frame_rate)
    if not path.exists():
        if re.search(r"%0?\d*d", path.name):
            return SequenceSource(files_of_pattern(path), frame_duration)
        raise InputError(f"{path}: must be a file, a folder or a pattern such as walk_%04d.png, got nothing there")
    if path.is_dir():
        return SequenceSource(files_of_folder(path, progress), frame_duration)
    if path.stat().st_size == 0:
        raise InputError(f"{path}: must be a video or an image, got an empty file")
    count = image_frame_count(path)
    if count > 1:
        return AnimationSource(path, progress, count)
    if count == 1:
        return SequenceSource((path,), STILL_DURATION)
    return VideoSource.open(path, progress)


def _name(path: Path) -> str:
    """What a clip is called: its file's stem, without the number of a pattern."""
    stem = path.resolve().name if path.is_dir() else path.stem
    return re.sub(r"[ ._-]*%0?\d*d", "", stem) or "clip"


def _count(source: FrameSource) -> int:
    """How many frames really come out."""
    return sum(1 for _ in source.frames())


def _select(source: FrameSource, chosen: slice, path: Path) -> Iterator[tuple[int, SourceFrame]]:
    """The chosen frames with their numbers, from 1; frames that are stepped over lengthen the one before."""
    step = 1 if chosen.step is None else chosen.step
    if step < 1:
        raise InputError(f"{path}: the step between frames must be at least 1, got {step}")
    start, stop = chosen.start or 0, sys.maxsize if chosen.stop is None else chosen.stop
    if start < 0 or stop < 0:
        start, stop, _ = slice(start, stop).indices(_count(source))
    held: tuple[int, SourceFrame] | None = None
    for index, frame in enumerate(islice(_in_order(source, path), stop if start < stop else 0)):
        if index < start:
            continue
        if held is not None and (index - start) % step:
            held = held[0], replace(held[1], duration=held[1].duration + frame.duration)
            continue
        if held is not None:
            yield held
        held = index + 1, frame
    if held is not None:
        yield held


def _in_order(source: FrameSource, path: Path) -> Iterator[SourceFrame]:
    """All frames from time 0, each later than the one before, all of one size and depth."""
    first: SourceFrame | None = None
    earliest = Fraction(0)
    for frame in source.frames():
        first = first or frame
        if frame.image.shape != first.image.shape:
            (height, width), (first_height, first_width) = frame.image.shape[:2], first.image.shape[:2]
            raise InputError(
                f"{path}: all frames must have the first one's size, {first_width} x {first_height} px, "
                f"got {width} x {height}"
            )
        time = max(frame.time - first.time, earliest)
        earliest = time + source.tick
        yield SourceFrame(_with_depth(frame.image, first.image.dtype), time, frame.duration)


def _with_depth(image: Pixels, dtype: np.dtype[Any]) -> Pixels:
    """The image with 8 or 16 bits per channel."""
    if image.dtype == dtype:
        return image
    return image * np.uint16(257) if dtype == np.uint16 else ((image + np.uint32(128)) // 257).astype(np.uint8)


def _exact_times(spans: list[tuple[Fraction, Fraction]], source: FrameSource) -> tuple[tuple[Fraction, ...], Fraction]:
    """Start of every frame, from 0, and end of the last one."""
    written = [time for time, _ in spans]
    times = on_exact_rate(written, source.rate, source.tick)
    last = spans[-1][1]
    if times is not written and source.rate:
        last = max(1, round(last * source.rate)) / source.rate
    return tuple(time - times[0] for time in times), times[-1] - times[0] + last

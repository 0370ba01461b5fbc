"""Frames of video files: mp4, mov, mkv, webm, avi, whatever FFmpeg reads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np

from videovec.decode_frame import Pixels, SourceFrame, broadcast_rate, to_rgb
from videovec.errors import InputError
from videovec.progress import Progress

__all__ = ["VideoSource", "on_exact_rate"]

NOT_VIDEO = {"tty", "image2", "svg_pipe", "lrc", "srt", "ass", "webvtt", "subviewer", "txt"}
"""Formats in which FFmpeg "plays" text files or pictures."""

ALPHA_DECODERS = {"vp8": "libvpx", "vp9": "libvpx-vp9"}
"""FFmpeg's own decoders of these drop the alpha channel that WebM stores beside the picture."""


@dataclass(frozen=True, slots=True)
class VideoSource:
    """The first video stream of a file.

    Args:
        path: The file.
        progress: Told about what could not be decoded.
        frame_count: Frames that the container promises, 0 if it does not say.
        rate: Its nominal frame rate.
        tick: Its clock. Seconds
        length: How long it is said to last, 0 if unknown. Seconds
    """

    path: Path
    progress: Progress
    frame_count: int
    rate: Fraction | None
    tick: Fraction
    length: Fraction

    @staticmethod
    def open(path: Path, progress: Progress) -> VideoSource:
        """Look at a file.

        Raises:
            InputError: FFmpeg cannot read it, or it has no moving picture.
        """
        with _container(path) as container:
            stream = _stream(container, path)
            rate = stream.average_rate or stream.guessed_rate
            return VideoSource(
                path,
                progress,
                int(stream.frames),
                broadcast_rate(rate) if rate else None,
                Fraction(stream.time_base or Fraction(1, 1000)),
                _length(container, stream),
            )

    def frames(self) -> Iterator[SourceFrame]:
        """All frames that decode, in order of time; damage is noted.

        Raises:
            InputError: None decodes.
        """
        count, damaged, first, end = 0, 0, Fraction(0), Fraction(0)
        with _container(self.path) as container:
            for frame in _decoded(container, _stream(container, self.path)):
                if frame is None or frame.is_corrupt:
                    damaged += 1
                    continue
                shown = self._source_frame(frame, count)
                first, end = (shown.time if count == 0 else first), shown.time + 2 * shown.duration
                yield shown
                count += 1
        if count == 0:
            raise InputError(f"{self.path}: must be a video with at least one whole frame, got none that decodes")
        if damaged or count < self.frame_count or end - first < self.length:
            self.progress.note(f"{self.path}: damaged or cut short; using the {count} frames that decode")

    def _source_frame(self, frame: Any, position: int) -> SourceFrame:
        step = 1 / (self.rate or Fraction(25))
        time = position * step if frame.pts is None else frame.pts * self.tick
        duration = frame.duration * self.tick if frame.duration else step
        return SourceFrame(_pixels(frame, str(self.path)), time, duration)


def _container(path: Path) -> Any:
    try:
        container = av.open(str(path))
    except av.error.FFmpegError as error:
        raise InputError(
            f"{path}: must be a video or an image, got something that FFmpeg cannot open ({error.strerror})"
        ) from error
    if container.format.name in NOT_VIDEO:
        container.close()
        raise InputError(
            f"{path}: must be a video or an image, got neither (FFmpeg takes it for: {container.format.long_name})"
        )
    return container


def _stream(container: Any, path: Path) -> Any:
    for stream in container.streams.video:
        if not stream.disposition & av.stream.Disposition.attached_pic and stream.codec_context is not None:
            return stream
    raise InputError(f"{path}: must hold a moving picture, got {len(container.streams)} streams of other kinds")


def _length(container: Any, stream: Any) -> Fraction:
    """How long the video is said to last, where only this tells a whole file from a cut one; else 0. Seconds"""
    if stream.frames or not container.duration or len(container.streams) > 1:
        return Fraction(0)
    return Fraction(container.duration, av.time_base)


def _decoded(container: Any, stream: Any) -> Iterator[Any]:
    """Decoded frames, and None for every packet that does not decode."""
    decoder = stream.codec_context
    if stream.metadata.get("alpha_mode") == "1" and decoder.name in ALPHA_DECODERS:
        decoder = av.CodecContext.create(ALPHA_DECODERS[decoder.name], "r")
        decoder.extradata = stream.codec_context.extradata
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
            if packet is None:
                return
            yield from decoder.decode(packet if packet.size else None)
        except av.error.EOFError:
            return
        except av.error.FFmpegError:
            yield None
            if packet is not None and not packet.size:
                return


def _pixels(frame: Any, what: str) -> Pixels:
    """Pixels of a decoded frame, turned as its display matrix says."""
    components = frame.format.components
    deep = max(component.bits for component in components) > 8
    has_alpha = any(component.is_alpha for component in components)
    layout = ("rgba64le" if has_alpha else "rgb48le") if deep else ("rgba" if has_alpha else "rgb24")
    image = to_rgb(frame.to_ndarray(format=layout), what)
    turns = round(frame.rotation / 90) % 4
    return np.ascontiguousarray(np.rot90(image, turns)) if turns else image


def on_exact_rate(times: list[Fraction], rate: Fraction | None, tick: Fraction) -> list[Fraction]:
    """Undo the rounding of times to a coarse clock, where all of them agree with one exact rate.

    Matroska and WebM write milliseconds, so that 24000/1001 frames a second come out as 0, 0.042, 0.083. Where every
    time lies within a tick of a multiple of the frame duration, the multiples are the times; dropped frames stay
    dropped, and a truly variable rate stays as it is written.

    Args:
        times: Strictly increasing, from 0. Seconds
        rate: Nominal frames per second; without one the times are returned as they are.
        tick: Step of the clock. Seconds
    """
    if rate is None or rate <= 0 or 2 * tick * rate > 1:
        return times
    places = [round(time * rate) for time in times]
    rises = all(a < b for a, b in pairwise(places))
    agrees = all(abs(place / rate - time) <= tick for place, time in zip(places, times, strict=True))
    return [place / rate for place in places] if rises and agrees else times

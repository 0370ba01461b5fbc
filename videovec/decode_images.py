"""Frames of image files: one, a numbered sequence, or an animated gif, apng or webp."""

from __future__ import annotations

import re
import struct
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import imageio.v3 as iio
import numpy as np
from PIL import Image, UnidentifiedImageError

from videovec.decode_frame import Pixels, SourceFrame, to_rgb
from videovec.errors import InputError
from videovec.progress import Progress

__all__ = ["AnimationSource", "SequenceSource", "files_of_folder", "files_of_pattern", "image_frame_count"]

IMAGE_SUFFIXES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm", ".pnm", ".tga", ".gif"}

UNSET_DELAY = Fraction(1, 10)
"""What players make of a delay of zero. Seconds"""


DAMAGE = (OSError, EOFError, ValueError, SyntaxError, struct.error, IndexError)
"""What Pillow raises where a file is damaged."""


def image_frame_count(path: Path) -> int:
    """How many frames an image file has, whole ones if it is damaged; 0 if it is no image."""
    try:
        with Image.open(path) as image:
            try:
                return int(getattr(image, "n_frames", 1))
            except DAMAGE:
                return max(1, _seekable(image))
    except UnidentifiedImageError:
        return 0
    except DAMAGE:
        return 1


def _seekable(image: Image.Image) -> int:
    """Number of frames before the damage."""
    for index in count():
        try:
            image.seek(index)
        except DAMAGE:
            return index
    raise AssertionError("files end")


@dataclass(frozen=True, slots=True)
class AnimationSource:
    """An animated gif, apng or webp."""

    path: Path
    progress: Progress
    frame_count: int
    rate: Fraction | None = None
    tick: Fraction = Fraction(1, 1000)

    def frames(self) -> Iterator[SourceFrame]:
        """All frames that decode; damage is noted.

        Raises:
            InputError: None decodes.
        """
        time, shown = Fraction(0), 0
        with Image.open(self.path) as image:
            first = 1 if getattr(image, "default_image", False) else 0
            for index in count(first):
                try:
                    image.seek(index)
                    pixels = np.asarray(image.convert("RGBA"))
                except DAMAGE as error:
                    if index < self.frame_count or not isinstance(error, EOFError):
                        self.progress.note(f"{self.path}: damaged or cut short; using the first {shown} frames")
                    break
                # An apng's delay is a fraction of two 16-bit numbers, which a double tells apart.
                delay = Fraction(float(image.info.get("duration", 0)) / 1000).limit_denominator(65535) or UNSET_DELAY
                yield SourceFrame(to_rgb(pixels, f"{self.path}"), time, delay)
                time, shown = time + delay, shown + 1
        if shown == 0:
            raise InputError(f"{self.path}: must have at least one whole frame, got none that decodes")


@dataclass(frozen=True, slots=True)
class SequenceSource:
    """Still images, one frame each."""

    paths: tuple[Path, ...]
    frame_duration: Fraction
    rate: Fraction | None = None
    tick: Fraction = Fraction(1, 1000)

    @property
    def frame_count(self) -> int:
        """Number of images."""
        return len(self.paths)

    def frames(self) -> Iterator[SourceFrame]:
        """All images, in order.

        Raises:
            InputError: One cannot be read.
        """
        for index, path in enumerate(self.paths):
            yield SourceFrame(_read_still(path), index * self.frame_duration, self.frame_duration)


def _read_still(path: Path) -> Pixels:
    """Read one image with all its bits, turned as EXIF says."""
    try:
        if _is_deep_color(path):
            return to_rgb(iio.imread(path, plugin="opencv", index=0, flags=cv2.IMREAD_UNCHANGED), str(path))
        file: Any = iio.imopen(path, "r", plugin="pillow")
        with file:
            mode = str(file.metadata(index=0)["mode"])
            plain = mode in {"1", "L", "LA", "RGB", "RGBA", "I", "I;16", "I;16B", "I;16L", "I;16N", "F"}
            return to_rgb(file.read(index=0, rotate=True, mode=None if plain else "RGBA"), str(path))
    except InputError:
        raise
    except Exception as error:  # image libraries raise nearly anything on damaged files
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: must be a readable image, got a damaged or unknown one ({reason})") from error


def _is_deep_color(path: Path) -> bool:
    """Whether a file has 16-bit colour, which Pillow would cut to 8 bits."""
    with path.open("rb") as file:
        head = file.read(26)
    if head[:8] == b"\x89PNG\r\n\x1a\n":
        return len(head) == 26 and head[24] == 16 and head[25] in (2, 4, 6)
    if head[:4] in (b"II*\0", b"MM\0*"):
        with Image.open(path) as image:
            bits = getattr(image, "tag_v2", {}).get(258, (8,))
            return len(bits) > 1 and max(bits) == 16
    return False


def _natural(name: str) -> list[tuple[int, str]]:
    """Sort key in which walk_2 comes before walk_10."""
    return [(int(part), "") if part.isdigit() else (-1, part.lower()) for part in re.split(r"(\d+)", name)]


def files_of_folder(folder: Path, progress: Progress) -> tuple[Path, ...]:
    """The numbered images of a folder: the largest set of names that differ in their last number alone.

    Raises:
        InputError: The folder has no image.
    """
    groups: dict[tuple[str, str], list[Path]] = defaultdict(list)
    for path in sorted(folder.iterdir(), key=lambda path: _natural(path.name)):
        if path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith(".") and path.is_file():
            match = re.fullmatch(r"(.*?)\d+(\D*)", path.name)
            groups[(match[1], match[2]) if match else ("", "")].append(path)
    if not groups:
        raise InputError(f"{folder}: must be a folder with numbered images, got one without any image")
    chosen = max(groups.values(), key=len)
    others = sum(len(group) for group in groups.values()) - len(chosen)
    if others:
        progress.note(f"{folder}: using {chosen[0].name} .. {chosen[-1].name}; {others} other images left out")
    return tuple(chosen)


def files_of_pattern(pattern: Path) -> tuple[Path, ...]:
    """Files that match a name with ``%d`` or ``%04d``, in the order of their numbers.

    Raises:
        InputError: No file matches.
    """
    parts = re.split(r"%0?\d*d", pattern.name)
    expression = re.compile(r"(\d+)".join(re.escape(part) for part in parts))
    found = [path for path in pattern.parent.glob("*") if expression.fullmatch(path.name)]
    if not found:
        raise InputError(f"{pattern}: must match numbered images such as {pattern.name % 1}, got none")
    return tuple(sorted(found, key=lambda path: _natural(path.name)))

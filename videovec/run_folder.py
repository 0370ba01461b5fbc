"""The folder of a run: whose it is, what was done in it, and whether that can be used again."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from videovec.clip import Clip
from videovec.config import describe_settings
from videovec.errors import OutputError
from videovec.files import write_file
from videovec.settings import Config

__all__ = ["TRACKS", "RunFolder", "RunRecord", "default_folder", "hash_of_clip", "hash_of_config"]

RECORD = "run.json"
TRACKS = "tracks.npz"
FORMAT = 1
"""Version of the layout of run.json."""


@dataclass(frozen=True, slots=True)
class RunRecord:
    """What run.json holds.

    Args:
        status: running, fitted (strokes are saved), done, unfinished (strokes are saved as far as they were fitted when
            the fit was interrupted), interrupted or failed.
        source: Where the clip is.
        frames: The part of it that was asked for: start, stop and step of a slice.
        clip: Frames, drawings, height, width, seconds.
        clip_hash: Names the decoded clip.
        config_hash: Names the settings that the strokes depend on.
        config: Every setting.
        versions: Versions of videovec and of the libraries.
        seconds: How long each stage took.
        metrics: What was measured of the result.
        frame_errors: Error of each frame: 0 is perfect, 1 is no better than an empty page.
        outputs: Files that were written, relative to the folder.
    """

    status: str
    source: str
    frames: tuple[int | None, int | None, int | None]
    clip: Mapping[str, float]
    clip_hash: str
    config_hash: str
    config: Mapping[str, object]
    versions: Mapping[str, str]
    seconds: Mapping[str, float] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)
    frame_errors: tuple[float, ...] = ()
    outputs: tuple[str, ...] = ()

    def seconds_spent(self) -> float:
        """How long all stages took."""
        return round(sum(self.seconds.values()), 1)

    def is_fitted_as(self, other: RunRecord) -> bool:
        """Whether its strokes are finished, and are those of the clip and the settings of ``other``."""
        return self._is_of(other) and self.status in {"fitted", "done"}

    def is_begun_as(self, other: RunRecord) -> bool:
        """Whether its strokes are those of an interrupted fit of the clip and the settings of ``other``."""
        return self._is_of(other) and self.status == "unfinished"

    def _is_of(self, other: RunRecord) -> bool:
        return (self.clip_hash, self.config_hash) == (other.clip_hash, other.config_hash)


def default_folder(source: str | Path) -> Path:
    """``NAME_videovec`` beside the clip, or here where that place cannot be written to."""
    path = Path(source).resolve()
    name = path.name if path.is_dir() else path.stem.partition("%")[0].rstrip("_-. ")
    parent = path.parent
    return (parent if os.access(parent, os.W_OK) else Path()) / f"{name or 'clip'}_videovec"


def hash_of_clip(clip: Clip) -> str:
    """A name for what was decoded: every pixel and every time."""
    digest = hashlib.blake2b(digest_size=16)
    for drawing in clip.drawings:
        digest.update(f"{drawing.shape}{drawing.dtype}".encode())
        digest.update(drawing.tobytes())
    timeline = clip.timeline
    shown = (timeline.drawing_of_frame.tolist(), timeline.times, timeline.duration, timeline.frame_numbers.tolist())
    digest.update(repr(shown).encode())
    return digest.hexdigest()


def hash_of_config(config: Config, version: str) -> str:
    """A name for everything that the strokes depend on, files that settings name among it.

    How strokes are written does not count.
    """
    settings = [setting for setting in describe_settings(config) if not setting.key.startswith("export.")]
    digest = hashlib.blake2b(version.encode(), digest_size=16)
    for setting in settings:
        digest.update(f"\n{setting.key}={setting.default!r}".encode())
        if isinstance(setting.default, str) and Path(setting.default).is_file():
            digest.update(Path(setting.default).read_bytes())
    return digest.hexdigest()


@dataclass(frozen=True, slots=True)
class RunFolder:
    """A folder that belongs to runs of videovec."""

    path: Path

    @staticmethod
    def claim(path: Path, *, force: bool = False) -> RunFolder:
        """Make sure that a run may write here; the folder itself is made when something is written.

        Args:
            path: The folder.
            force: Write even among files of others.

        Raises:
            OutputError: It is a file, holds files of others, or cannot be written to.
        """
        folder = RunFolder(path)
        if path.exists() and not path.is_dir():
            raise OutputError(f"the output folder {path} is a file")
        if path.is_dir() and any(path.iterdir()) and folder.record() is None and not force:
            raise OutputError(f"{path} holds files that are not from videovec; choose another with -o, or add --force")
        existing = next(place for place in (path, *path.absolute().parents) if place.exists())
        if not os.access(existing, os.W_OK):
            raise OutputError(f"cannot write to {existing}")
        return folder

    def record(self) -> RunRecord | None:
        """What run.json says, or nothing where there is none that can be read."""
        try:
            content = json.loads((self.path / RECORD).read_text(encoding="utf-8"))
            if content.pop("format") != FORMAT:
                return None
            lists = {name: tuple(content[name]) for name in ("frames", "frame_errors", "outputs")}
            return RunRecord(**{**content, **lists})
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            return None

    def write_record(self, record: RunRecord) -> None:
        """Write run.json, whole or not at all."""
        text = json.dumps({"format": FORMAT, **asdict(record)}, indent=1, ensure_ascii=False) + "\n"
        write_file(self.path / RECORD, text)

    def has_tracks(self) -> bool:
        """Whether strokes are there."""
        return (self.path / TRACKS).is_file()

    def remove_stale(self, names: Iterable[str]) -> None:
        """Remove files of an earlier run, by their names in its record; nothing outside the folder."""
        for name in sorted(names):
            place = (self.path / name).resolve()
            if place.is_relative_to(self.path.resolve()):
                place.unlink(missing_ok=True)

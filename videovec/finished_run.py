"""A folder that a run has filled: its strokes, its settings and its clip, for whoever comes afterwards."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from videovec.clip import Clip
from videovec.config import configure, flatten
from videovec.decode import decode
from videovec.errors import ConfigError, InputError
from videovec.export import export
from videovec.progress import Progress, Silent
from videovec.run_folder import TRACKS, RunFolder, RunRecord
from videovec.settings import Config
from videovec.tracks import StrokeTracks

__all__ = ["FinishedRun"]


@dataclass(frozen=True, slots=True)
class FinishedRun:
    """What is left of a run."""

    folder: RunFolder
    record: RunRecord

    @staticmethod
    def open(path: Path) -> FinishedRun:
        """Look into a folder.

        Raises:
            InputError: No run has finished there.
        """
        folder = RunFolder(path)
        record = folder.record()
        if record is None:
            raise InputError(f"{path} must be the folder of a run, such as clip_videovec, got one without a run.json")
        if record.status not in {"fitted", "done"}:
            raise InputError(f"{path} must be the folder of a finished run, got one that is {record.status}")
        return FinishedRun(folder, record)

    def tracks(self) -> StrokeTracks:
        """Its strokes."""
        return StrokeTracks.load(self.folder.path / TRACKS)

    def config(self, overrides: Iterable[str] = ()) -> Config:
        """Its settings, some of them changed; settings that this version no longer knows are left out.

        Raises:
            ConfigError: An override does not fit.
        """
        config = Config()
        for key, value in flatten(self.record.config):
            with suppress(ConfigError):
                config = configure(None, {key: value}, base=config)
        return configure(None, overrides, base=config)

    def clip(self, progress: Progress | None = None) -> Clip | None:
        """Its clip, or nothing where that has moved away."""
        try:
            return decode(self.record.source, self.config().decode, slice(*self.record.frames), progress)
        except InputError as error:
            (progress or Silent()).note(f"the clip is missing, so pictures show the strokes alone: {error}")
            return None

    def preview(self) -> Path:
        """Its preview: the film, or the picture of a still.

        Raises:
            InputError: It was not written.
        """
        for name in ("preview.png", "preview.mp4"):
            if (self.folder.path / name).exists():
                return self.folder.path / name
        raise InputError(f"{self.folder.path} must hold a preview, got none; write it: videovec export -f preview")

    def figures(self) -> dict[str, float]:
        """What was measured of it, by name."""
        return {**self.record.clip, **self.record.metrics, "seconds_spent": self.record.seconds_spent()}

    def export(
        self,
        formats: Sequence[str],
        overrides: Iterable[str] = (),
        out: Path | None = None,
        progress: Progress | None = None,
    ) -> list[Path]:
        """Write its strokes again, without fitting.

        Args:
            formats: What to write.
            overrides: ``key=value`` texts, of which those of ``export`` matter.
            out: Where to; its own folder unless told.
            progress: Told of every format.

        Returns:
            The files that were written.

        Raises:
            ConfigError: A format or setting does not exist.
            OutputError: The folder cannot be written to.
        """
        config, tracks = self.config(overrides), self.tracks()
        if tuple(formats) == ("brush",) and tracks.brushwork is None:
            raise ConfigError(
                f"{self.folder.path} has no brush: its lines were fitted as solid; run it with --preset textured"
            )
        clip = self.clip(progress) if {"preview", "report"} & set(formats) else None
        target = out or self.folder.path
        written = export(tracks, clip, target, config.export, formats, progress)
        if target == self.folder.path:
            names = {path.relative_to(target).as_posix() for path in written}
            outputs = tuple(sorted(names | set(self.record.outputs)))
            self.folder.write_record(replace(self.record, outputs=outputs))
        return written

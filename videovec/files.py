"""The one edge of the program that writes files: whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from videovec.errors import OutputError

__all__ = ["OutputFile", "write_file", "write_folder"]


@dataclass(frozen=True, slots=True)
class OutputFile:
    """What a writer gives: bytes and where they belong.

    Args:
        path: Place under the folder of outputs, with forward slashes.
        data: Content of the file.
    """

    path: str
    data: bytes


def write_file(path: Path, data: bytes | str) -> Path:
    """Write a file whole: into a temporary neighbour, which then takes its name.

    Args:
        path: Where to; missing folders are made.
        data: Content; text is encoded as UTF-8.

    Returns:
        The path.

    Raises:
        OutputError: The place cannot be written to.
    """
    content = data.encode() if isinstance(data, str) else data
    temporary: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".partial", dir=path.parent)
        temporary = Path(name)
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
    return path


def write_folder(folder: Path, files: Iterable[OutputFile]) -> Path:
    """Write a folder whole: an older one of that name is replaced when all files of the new one are there.

    Args:
        folder: Where to; what lies in it is lost.
        files: Content, with paths under the folder.

    Returns:
        The folder.

    Raises:
        OutputError: The place cannot be written to, or is a file.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"cannot write {folder}: it must be a folder, and a file of that name exists")
    temporary: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".partial", dir=folder.parent))
        os.chmod(temporary, 0o777 & ~_umask())
        for file in files:
            target = temporary / file.path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(file.data)
        _swap(temporary, folder)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
    return folder


def _swap(new: Path, folder: Path) -> None:
    """Give ``new`` the name of ``folder``; what had it moves into ``new``'s old name and is left to be removed."""
    if not folder.exists():
        os.replace(new, folder)
        return
    with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", suffix=".old", dir=folder.parent) as aside:
        old = Path(aside) / folder.name
        os.replace(folder, old)
        try:
            os.replace(new, folder)
        except OSError:
            with suppress(OSError):
                os.replace(old, folder)
            raise


def _umask() -> int:
    """Permissions that new files do not get; temporary ones are made private."""
    mask = os.umask(0)
    os.umask(mask)
    return mask

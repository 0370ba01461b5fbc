"""Files and folders appear whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from videovec.errors import OutputError
from videovec.files import OutputFile, write_file, write_folder


def test_a_file_takes_the_place_of_an_older_one_and_leaves_nothing_behind(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "notes.txt"
    write_file(path, "first")
    write_file(path, "zweite, größer")
    assert path.read_text(encoding="utf-8") == "zweite, größer"
    assert list(path.parent.iterdir()) == [path]


def test_a_file_has_the_permissions_of_any_other(tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    path = write_file(tmp_path / "ours", b"x")
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)


def test_a_failed_write_keeps_the_older_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_file(tmp_path / "notes.txt", "old")

    def full(*args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match=r"cannot write .*notes\.txt: No space left on device"):
        write_file(path, "new")
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder = tmp_path / "svg"
    write_folder(folder, [OutputFile("a.svg", b"a"), OutputFile("b.svg", b"b")])
    write_folder(folder, [OutputFile("b.svg", b"B"), OutputFile("inner/c.svg", b"c")])
    found = {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.svg")}
    assert found == {"b.svg": b"B", "inner/c.svg": b"c"}
    assert list(tmp_path.iterdir()) == [folder]


def test_a_folder_stays_as_it_was_when_its_content_cannot_be_made(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "svg", [OutputFile("a.svg", b"a")])

    def torn() -> Iterator[OutputFile]:
        yield OutputFile("a.svg", b"new")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_folder(folder, torn())
    assert (folder / "a.svg").read_bytes() == b"a"
    assert list(tmp_path.iterdir()) == [folder]


def test_a_file_in_the_place_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "svg").touch()
    with pytest.raises(OutputError, match="it must be a folder"):
        write_folder(tmp_path / "svg", [])
    with pytest.raises(OutputError, match="cannot write"):
        write_file(tmp_path / "svg" / "a.svg", "a")

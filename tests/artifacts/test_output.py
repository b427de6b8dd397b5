"""Files where the user wants them."""

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.artifacts.output import check_writable, is_written_through, output_folder, place_output, write_output

Write = Callable[[Path, bytes], None]


def write(path: Path, content: bytes) -> None:
    """Write a file at once."""
    check_writable(path)
    write_output(path, content)


def place(path: Path, content: bytes) -> None:
    """Write a file elsewhere first."""
    check_writable(path)
    folder = output_folder(path)
    written = path.parent / "written" if folder is None else folder / "written"
    written.write_bytes(content)
    place_output(written, path)
    written.unlink(missing_ok=True)


both = pytest.mark.parametrize("write", [write, place])


@both
def test_a_regular_file(tmp_path: Path, write: Write) -> None:
    """It is made, and replaced as a whole: whoever has it open keeps what was in it."""
    write(tmp_path / "a", b"old")
    with (tmp_path / "a").open("rb") as opened:
        write(tmp_path / "a", b"new")
        assert opened.read() == b"old"
    assert (tmp_path / "a").read_bytes() == b"new"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@both
@pytest.mark.parametrize("there", [True, False])
def test_of_a_link_the_target_is_written(tmp_path: Path, write: Write, there: bool) -> None:
    """Links stay links, also several in a row, and to a file that does not exist yet."""
    (tmp_path / "data").mkdir()
    if there:
        (tmp_path / "data" / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to("data/real")
    (tmp_path / "link2").symlink_to(tmp_path / "link")
    write(tmp_path / "link2", b"new")
    assert (tmp_path / "link2").is_symlink()
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "data" / "real").read_bytes() == b"new"
    assert not (tmp_path / "data" / "real").is_symlink()


@both
@pytest.mark.parametrize("linked", [True, False])
def test_a_pipe_is_written_through(tmp_path: Path, write: Write, linked: bool) -> None:
    """All of it arrives, more than a pipe holds at a time; the pipe stays."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    if linked:
        path = tmp_path / "link"
        path.symlink_to("pipe")
    assert is_written_through(path)
    writer = threading.Thread(target=write, args=(path, b"x" * 300_000))
    writer.start()
    assert (tmp_path / "pipe").read_bytes() == b"x" * 300_000
    writer.join()
    assert (tmp_path / "pipe").is_fifo()


@both
def test_a_device_is_written_through(tmp_path: Path, write: Write) -> None:
    """It stays a device; one that is full says so by its name."""
    (tmp_path / "null").symlink_to(os.devnull)
    write(tmp_path / "null", b"new")
    assert Path(os.devnull).is_char_device()
    (tmp_path / "full").symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left") as refused:
        write(tmp_path / "full", b"new")
    assert refused.value.filename == str(tmp_path / "full")


@both
def test_what_is_open_is_appended_to(tmp_path: Path, write: Write) -> None:
    """`--output /dev/stdout >> log` keeps what is in the log."""
    (tmp_path / "log").write_bytes(b"before ")
    with (tmp_path / "log").open("ab") as log:
        (tmp_path / "link").symlink_to(f"/dev/fd/{log.fileno()}")
        write(tmp_path / "link", b"after")
    assert (tmp_path / "log").read_bytes() == b"before after"


@both
def test_what_cannot_be_written_is_named(tmp_path: Path, write: Write) -> None:
    """Folders, loops of links, and files in place of folders, by the name that the user gave."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "file").touch()
    before = sorted(tmp_path.rglob("*"))
    for name in ("folder", "loop", "loop/a", "file/a"):
        with pytest.raises(OSError, match=r"directory|links") as refused:
            write(tmp_path / name, b"new")
        assert refused.value.filename == str(tmp_path / name)
    assert sorted(tmp_path.rglob("*")) == before


def test_folders_are_made(tmp_path: Path) -> None:
    """A file may be asked for in a folder that does not exist yet."""
    write(tmp_path / "new" / "folder" / "a", b"new")
    assert (tmp_path / "new" / "folder" / "a").read_bytes() == b"new"


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_what_may_not_be_written_is_named(tmp_path: Path) -> None:
    """A protected file, and a file in a protected folder: by their names, with what is protected."""
    (tmp_path / "a").touch(0o400)
    with pytest.raises(PermissionError, match="may not be written"):
        write(tmp_path / "a", b"new")
    (tmp_path / "folder").mkdir(0o500)
    with pytest.raises(PermissionError, match="nothing may be written to its folder") as refused:
        write(tmp_path / "folder" / "b", b"new")
    assert refused.value.filename == str(tmp_path / "folder" / "b")

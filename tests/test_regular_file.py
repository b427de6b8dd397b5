import errno
import os
import socket
from pathlib import Path

import pytest

from pipeline.regular_file import open_regular_file, read_named_file, read_regular_file

MOST = 1000


def _folder(path: Path) -> None:
    path.mkdir()


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(path))


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


@pytest.mark.parametrize("make", [_folder, _pipe, _socket, _device])
@pytest.mark.parametrize("linked", [False, True])
def test_what_is_not_regular_is_refused_without_waiting(tmp_path, make, linked):
    """Folders, pipes, sockets and devices are named as what they are, also behind a link."""
    path = tmp_path / "file"
    make(path)
    if linked:
        path = tmp_path / "link"
        path.symlink_to("file")
    with pytest.raises(OSError, match=r"is a (folder|pipe|socket|device), not a regular file") as refused:
        open_regular_file(path, MOST)
    assert refused.value.filename == str(path)


@pytest.mark.parametrize("read", [read_regular_file, read_named_file])
def test_content_up_to_the_limit_is_read_and_no_more(tmp_path, read):
    """A file of exactly the limit is read; one byte more is refused with both numbers."""
    path = tmp_path / "file"
    path.write_bytes(b"x" * MOST)
    assert read(path, MOST) == b"x" * MOST
    path.write_bytes(b"x" * (MOST + 1))
    with pytest.raises(OSError, match="at most 1,000 are read") as refused:
        read(path, MOST)
    assert refused.value.errno == errno.EFBIG


def test_sparse_files_are_refused_by_their_size(tmp_path):
    """A terabyte of nothing is refused before any of it is read."""
    path = tmp_path / "huge"
    with path.open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(OSError, match="has 1,000,000,000,000 bytes"):
        read_regular_file(path, MOST)


def test_missing_files_and_loops_of_links_are_errors_of_the_system(tmp_path):
    """They keep the error that the system gives them."""
    with pytest.raises(FileNotFoundError):
        read_regular_file(tmp_path / "missing", MOST)
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OSError) as refused:
        read_regular_file(tmp_path / "loop", MOST)
    assert refused.value.errno == errno.ELOOP


def test_a_named_device_is_read_up_to_the_limit():
    """What the user named may be a pipe or a device, but not one without an end."""
    assert read_named_file(Path(os.devnull), MOST) == b""
    with pytest.raises(OSError, match="has more than 1,000 bytes"):
        read_named_file(Path("/dev/zero"), MOST)

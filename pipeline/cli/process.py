"""The process of the command line: what has to be settled before anything that loads slowly is imported."""

import io
import os
import sys

from pipeline.startup import end_at_interrupts


def main() -> None:
    """Run the command line of this process."""
    interruptible = end_at_interrupts()
    # Matrices are small: threads of linear algebra would only wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _open_standard_streams()
    from typer.main import get_command

    from pipeline.cli.application import app
    from pipeline.cli.interrupts import raise_interrupts

    # Built before interrupts become exceptions: only the command itself reports them.
    command = get_command(app)
    if interruptible:
        raise_interrupts()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout = _complete(sys.stdout)
    command()


def _open_standard_streams() -> None:
    """Open what is closed, so that no file gets its number: solvers write there; printing fails as it should."""
    for number, flags in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, flags)
    if sys.stdout is None:
        sys.stdout = os.fdopen(1, "w", closefd=False)
    if sys.stderr is None:
        sys.stderr = os.fdopen(2, "w", closefd=False)


def _complete(stream: io.TextIOWrapper) -> io.TextIOWrapper:
    """Make a stream write everything or fail.

    A locale without umlauts must not end the program after its work is done. Without a buffer (PYTHONUNBUFFERED),
    Python drops what a full disk or an interrupted write has not taken.
    """
    if isinstance(stream.buffer, io.RawIOBase):
        raw, encoding = stream.buffer, stream.encoding
        stream.detach()
        stream = io.TextIOWrapper(io.BufferedWriter(raw), encoding=encoding, line_buffering=True)
    stream.reconfigure(errors="backslashreplace")
    return stream

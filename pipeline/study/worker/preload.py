"""What workers on this machine do when they start: Ctrl-C is the client's, which ends them in order."""

import signal


def dask_setup(_worker: object) -> None:
    """Ignore Ctrl-C, which a terminal gives to all processes; Dask calls this by its name."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

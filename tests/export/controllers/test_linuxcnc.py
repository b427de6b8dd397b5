"""Lines for halstreamer and the HAL file beside them, played by LinuxCNC's own HAL where it is installed."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import ExportOptions, ExportRequest, export_files
from pipeline.export.controllers.linuxcnc import format_hal
from pipeline.export.formats import Format, LengthUnit
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])
SCALE = 1e6
"""halsampler prints six decimals: positions are scaled before it."""
PLAY = """\
halsampler > seen.txt &
sleep 0.2
halstreamer motion.txt
halcmd sets tau-go 1
until [ "$(halcmd getp streamer.0.underruns)" -gt 20 ]; do sleep 0.05; done
kill $!
wait
"""


def test_the_hal_file_fits_the_motion(make_samples) -> None:
    """Its period is in whole nanoseconds, the FIFO takes every row, the first row is what the selectors hold."""
    samples = make_samples(0.000125)
    text = format_hal(ExportRequest(samples, LIMITS, ("a", "b", "c", "d", "e")))
    assert "loadrt threads name1=tau-thread period1=125000\n" in text
    assert f"depth={len(samples) + 1} cfg=fffff" in text
    held = [float(value) for value in re.findall(r"setp mux2\.\d\.in0 (\S+)", text)]
    assert held == pytest.approx(samples.q_m[0], abs=1e-12)
    assert re.findall(r"net (\w+)-command mux2\.\d\.out  # (\w)", text) == list(zip(ACTUATORS, "abcde", strict=True))


def test_lengths_in_millimetres(make_samples) -> None:
    """Joints of controllers are mostly configured so: lines, held row and comment change together."""
    samples = make_samples(0.01)
    request = ExportRequest(samples, LIMITS, ACTUATORS, ExportOptions(length=LengthUnit.MM))
    files = {suffix: content.decode() for suffix, content in export_files(Format.LINUXCNC, request).items()}
    assert "# pins: c1 c2 c3 l2b l3b, millimetres\n300.000000000 0.000000000 2100.000000000 1090" in files[""]
    assert "setp mux2.3.in0 1090.000000000\n" in files[".hal"]


def test_motions_that_do_not_fit_are_refused(make_samples) -> None:
    """A FIFO that has to be filled on the way may run empty."""
    with pytest.raises(UsageError, match=r"rows do not fit into streamer's FIFO.*\n.*--period"):
        format_hal(ExportRequest(make_samples(5e-7), LIMITS, ACTUATORS))


@pytest.mark.skipif(shutil.which("halrun") is None, reason="LinuxCNC is not installed: apt-get install linuxcnc-uspace")
def test_linuxcnc_plays_every_row_and_never_jumps(reference: TrajectorySamples, tmp_path: Path) -> None:
    """Threads, streamer, halstreamer and sampler: the first row stands before, each row comes once, the last stays."""
    samples = _part(reference, 200, 0.001)
    played = _play(ExportRequest(samples, LIMITS, ACTUATORS), tmp_path)
    exact = SCALE * samples.q_m
    assert played[0] == pytest.approx(exact[0], abs=1e-3)
    changes = np.flatnonzero(np.abs(np.diff(played, axis=0)).max(axis=1) > 1e-3)
    start = changes[0]
    assert start > 20, "the machine stands at the first row before it starts"
    motion = played[start : start + len(samples)]
    assert motion == pytest.approx(exact, abs=2e-3)
    assert np.abs(played[start + len(samples) :] - exact[-1]).max(initial=0.0) < 1e-3


def _part(samples: TrajectorySamples, first: int, period_s: float) -> TrajectorySamples:
    """Take 200 rows from the middle of a motion, and call their distance another period."""
    rows = slice(first, first + 200)
    t = period_s * np.arange(200)
    parts = (samples.q_m[rows], samples.qd_mps[rows], samples.qdd_mps2[rows], samples.pose[rows], samples.kappa[rows])
    return TrajectorySamples(period_s, t, *parts)


def _play(request: ExportRequest, folder: Path) -> np.ndarray:
    """Play a motion in LinuxCNC without real time, and sample the commands (n, 5) in the same thread."""
    files = export_files(Format.LINUXCNC, request)
    (folder / "motion.txt").write_bytes(files[""])
    scales = [
        line
        for k, name in enumerate(ACTUATORS)
        for line in (
            f"setp scale.{k}.gain {SCALE}",
            f"addf scale.{k} tau-thread",
            f"net {name}-command => scale.{k}.in",
            f"net {name}-seen scale.{k}.out => sampler.0.pin.{k}",
        )
    ]
    watch = [
        "loadrt scale count=5",
        "loadrt sampler cfg=fffff depth=20000",
        *scales,
        "addf sampler.0 tau-thread",
    ]
    text = (
        files[".hal"].decode().replace("\nstart\n", "\n" + "\n".join([*watch, "start", "loadusr -w sh play.sh"]) + "\n")
    )
    (folder / "motion.hal").write_text(text)
    (folder / "play.sh").write_text(PLAY)
    for path in (folder, *folder.iterdir()):
        path.chmod(0o777)
    # As root, the realtime process wants to know what user it may become; its socket is a file.
    environment = {**os.environ, "RTAPI_UID": str(os.getuid() or 65534), "RTAPI_FIFO_PATH": f"/tmp/rtapi_{os.getpid()}"}
    command = ["halrun", "-f", "motion.hal"]
    ended = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert (folder / "seen.txt").exists(), ended.stderr
    return np.loadtxt(folder / "seen.txt")

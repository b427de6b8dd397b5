"""Studies that are killed: client, worker or scheduler, at random moments, until the study is done all the same.

`python -m tests.benchmarks.study_kills --kills 25` says what was killed, and compares the table with a calm one.
"""

import argparse
import contextlib
import csv
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil

from pipeline.yaml_text import parse_yaml

ROOT = Path(__file__).parents[2]
TIMES = ("seconds",)
"""What differs between two runs of the same study: columns that end in one of these."""
_ENDS_S = 60.0
_KINDS = ("client", "scheduler", "worker")
STUDY = """
base: {base}
to: route
parameters:
  - {{key: route.kappa_max, min: 60, max: 100, count: {count}}}
  - {{keys: [task.start.mode, task.goal.mode], values: [[LLL, RRR], [RRR, LLL]]}}
  - {{key: task.tilt_max_deg, values: [15, 30]}}
run: {{time_limit_s: 120}}
"""


@dataclass
class Cluster:
    """A scheduler, workers and a client, each a process that can be killed and started again."""

    study: Path
    out: Path
    port: int = 0
    workers: int = 2
    processes: dict[str, "subprocess.Popen[bytes]"] = field(default_factory=dict)

    def start(self, name: str) -> None:
        """Start a process by its name: `scheduler`, `worker 0`, ..., `client`."""
        self.port = self.port or free_port()
        address = f"tcp://127.0.0.1:{self.port}"
        arguments = {
            "scheduler": ["distributed.cli.dask_scheduler", "--port", str(self.port), "--host", "127.0.0.1"],
            "worker": ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"],
            "client": ["pipeline", "study", str(self.study), "--out", str(self.out), "--scheduler", address],
        }[name.split()[0]]
        if name == "scheduler":
            arguments += ["--no-dashboard"]
        self.processes[name] = subprocess.Popen(
            [sys.executable, "-m", *arguments], env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        if name == "scheduler":
            wait_for_port(self.port)

    def start_all(self) -> None:
        """Start what does not run: first the scheduler, then workers and the client."""
        for name in ("scheduler", *(f"worker {k}" for k in range(self.workers)), "client"):
            if name not in self.processes or self.processes[name].poll() is not None:
                self.start(name)

    def kill(self, kind: str, random_numbers: random.Random) -> str:
        """Kill -9 a process of a kind: of a worker any of its processes; say which."""
        name = f"worker {random_numbers.randrange(self.workers)}" if kind == "worker" else kind
        process = psutil.Process(self.processes[name].pid)
        family = [process, *(process.children(recursive=True) if kind == "worker" else [])]
        victim = random_numbers.choice(family)
        place = family.index(victim)
        with contextlib.suppress(psutil.Error):
            victim.send_signal(signal.SIGKILL)
        return f"{name}, process {place + 1} of {len(family)}"

    def end(self, *names: str) -> None:
        """End processes with all that they have begun."""
        for name in names or tuple(self.processes):
            process = self.processes.pop(name, None)
            if process is None:
                continue
            with contextlib.suppress(psutil.Error):
                for child in psutil.Process(process.pid).children(recursive=True):
                    child.kill()
            process.kill()
            process.wait()


def run_with_kills(study: Path, out: Path, kills: int, seed: int, pause_s: float = 12.0) -> list[str]:
    """Run a study while processes are killed at random moments; return what was killed.

    Raises
    ------
    RuntimeError
        When the client ends with an error that is not about the scheduler, or does not end.
    """
    numbers, said = random.Random(seed), list[str]()
    cluster = Cluster(study, out)
    try:
        cluster.start_all()
        while True:
            process = cluster.processes["client"]
            with contextlib.suppress(subprocess.TimeoutExpired):
                wait = numbers.uniform(0.2, pause_s) if len(said) < kills else 600.0
                code = process.wait(wait)
                if code == 0:
                    return said
                cluster.start_all()
                continue
            if len(said) >= kills:
                raise RuntimeError("the client does not end")
            kind = numbers.choice(_KINDS)
            said.append(cluster.kill(kind, numbers))
            if kind == "scheduler":
                cluster.processes["client"].wait(_ENDS_S)
                cluster.end()
            time.sleep(0.1)
            cluster.start_all()
    finally:
        cluster.end()


def table(out: Path) -> list[dict[str, str]]:
    """Read the table of a study without what is a time."""
    with (out / "study.csv").open() as file:
        rows = list(csv.DictReader(file))
    return [{name: text for name, text in row.items() if not name.endswith(TIMES)} for row in rows]


def write_study(folder: Path, count: int, base: Path = ROOT / "configs" / "tiny.yaml") -> Path:
    """Write a study of four runs per `count`, half of which have no route."""
    file = folder / "kills.yaml"
    file.write_text(STUDY.format(base=base, count=count))
    assert isinstance(parse_yaml(file.read_text()), dict)
    return file


def environment() -> dict[str, Any]:
    """Give processes the modules of this one."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)])}


def free_port() -> int:
    """Find a port that nobody listens to."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_for_port(port: int) -> None:
    """Wait until somebody listens."""
    until = time.monotonic() + _ENDS_S
    while time.monotonic() < until:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
            return
        time.sleep(0.1)
    raise TimeoutError(f"nobody listens to port {port}")


def main() -> None:
    """Kill as often as asked, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=25)
    parser.add_argument("--count", type=int, default=25, help="a quarter of the runs")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = write_study(folder, asked.count)
        began = time.monotonic()
        killed = run_with_kills(study, folder / "killed", asked.kills, asked.seed)
        print(f"{len(killed)} kills in {time.monotonic() - began:.0f} s:", *killed, sep="\n  ")  # noqa: T201
        run_with_kills(study, folder / "calm", 0, 0)
        same = table(folder / "killed") == table(folder / "calm")
        print(f"tables of {len(table(folder / 'calm'))} runs are {'the same' if same else 'not the same'}")  # noqa: T201
        raise SystemExit(0 if same else 1)


if __name__ == "__main__":
    main()

"""A run of a calibrated machine: simulated poses, what they say of the machine, and a short path of it."""

import json
import shutil
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from pipeline.artifacts import Record, State, json_bytes, open_run_folder
from pipeline.artifacts.layout import CERTIFICATE_JSON, PATH_NPZ
from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.certificate.stored import certificate_bytes
from pipeline.artifacts.results.path import pack_refinement
from pipeline.calibrate import Setting, StaticSetting, calibrate, calibrated_yaml, judge, simulate_static
from pipeline.calibrate.report import calibration_data
from pipeline.certify import certify_path
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config, parse_config
from pipeline.machine import Machine, build_machine
from pipeline.refine.result import Path as RefinedPath
from pipeline.refine.result import Refinement
from pipeline.stage import Stage
from pipeline.status import Status
from pipeline.summary.certificate import certificate_section
from pipeline.yaml_text import parse_yaml
from tests.certify.paths import START, pose_path

REFLECTORS_M = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])
GOAL = np.array([1.05, 0.33, 0.88, *np.deg2rad([2.0, -1.0])])


@dataclass(frozen=True, eq=False)
class CalibratedRun:
    """A run folder, the file of the calibration, and what both are of."""

    folder: Path
    calibration: Path
    config: Config
    machine: Machine
    path: RefinedPath

    def copied(self, to: Path) -> "CalibratedRun":
        """Give a copy, to be changed."""
        folder = Path(shutil.copytree(self.folder, to / "run"))
        return replace(self, folder=folder, calibration=Path(shutil.copy(self.calibration, to / "real.json")))


@pytest.fixture(scope="session")
def true_run(tmp_path_factory: pytest.TempPathFactory, quick_config: Config) -> CalibratedRun:
    """Calibrate a machine with 40 poses, and certify a short path of it."""
    simulated = simulate_static(quick_config, REFLECTORS_M, StaticSetting(poses=40, seed=3))
    found = calibrate(quick_config, REFLECTORS_M, simulated.poses, Setting())
    text = calibrated_yaml(dump_config(quick_config), quick_config, found.identification.model, "Calibrated.")
    config = parse_config(parse_yaml(text))
    start = config.task.start.model_copy(
        update=dict(zip(("x_m", "y_m", "z_m", "rx_deg", "rz_deg"), START.tolist(), strict=True))
    )
    goal = start.model_copy(update={"x_m": 1.05, "y_m": 0.33, "z_m": 0.88, "rx_deg": 2.0, "rz_deg": -1.0})
    task = config.task.model_copy(update={"start": start, "goal": goal})
    config = config.model_copy(update={"task": task})
    machine = build_machine(config.machine)
    path = pose_path(machine, np.linspace(START, GOAL, 7), 0, nodes=7)
    folder = tmp_path_factory.mktemp("calibrated")
    write(folder / "run", config, path)
    (folder / "real.json").write_bytes(json_bytes(calibration_data(found, judge(found))))
    return CalibratedRun(folder / "run", folder / "real.json", config, machine, path)


def write(folder: Path, config: Config, path: RefinedPath) -> None:
    """Write what a run up to the certificate leaves behind."""
    certificate = certify_path(config, path.machine, path)
    refinement = Refinement(path, path, Status.CONVERGED, 1, 1, 1, None, 1, 0.0)
    files = {
        Stage.REFINE: {PATH_NPZ: npz_bytes(pack_refinement(refinement))},
        Stage.CERTIFY: {CERTIFICATE_JSON: certificate_bytes(certificate, {"seconds": 1.0})},
    }
    summaries = {Stage.REFINE: {"status": "done"}, Stage.CERTIFY: certificate_section(certificate)}
    records = {stage: _record(made, summaries[stage]) for stage, made in files.items()}
    state = State(config_sha256=config_sha256(config), stages=records)
    with open_run_folder(folder) as run:
        run.change(state, {**files[Stage.REFINE], **files[Stage.CERTIFY]}, [], dump_config(config), {})


def _record(files: dict[str, bytes], summary: dict[str, object]) -> Record:
    return Record(
        fingerprint="0" * 64,
        status="done",
        seconds=1.0,
        files={name: sha256(content).hexdigest() for name, content in files.items()},
        sizes={name: len(content) for name, content in files.items()},
        summary=json.loads(json_bytes(summary)),
    )


@pytest.fixture
def calibrated_run(true_run: CalibratedRun, tmp_path: Path) -> CalibratedRun:
    """Give a copy of the run."""
    return true_run.copied(tmp_path)

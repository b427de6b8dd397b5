"""Runs with a certificate, written as runs are, forged as one likes, and checked on the command line."""

import json
import pathlib
from collections.abc import Callable
from typing import Any

import numpy as np
from typer.testing import CliRunner, Result

from pipeline.artifacts import State, open_run_folder
from pipeline.artifacts.layout import CERTIFICATE_JSON, PATH_NPZ
from pipeline.artifacts.npz import npz_bytes
from pipeline.artifacts.results.certificate.stored import certificate_bytes, chains
from pipeline.artifacts.results.following import following_files
from pipeline.artifacts.results.path import pack_refinement
from pipeline.certify import Certificate, Tolerance
from pipeline.certify.chain import close_chain
from pipeline.certify.following.steps import following_profile
from pipeline.certify.problem import build_problem
from pipeline.certify.result import proven_chain
from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.refine import Path
from pipeline.refine.result import Refinement
from pipeline.status import Status

Data = dict[str, Any]


def write_run(folder: pathlib.Path, config: Config, path: Path, certificate: Certificate) -> None:
    """Write what a run leaves behind of a path and its certificate."""
    refinement = Refinement(path, path, Status.CONVERGED, 1, 1, 1, None, 1, 0.0)
    files = {
        PATH_NPZ: npz_bytes(pack_refinement(refinement)),
        CERTIFICATE_JSON: certificate_bytes(certificate, {"seconds": 1.0}),
    }
    if (profile := following_profile(chains(certificate))) is not None:
        files |= following_files(profile, None)
    with open_run_folder(folder) as run:
        run.change(State(config_sha256=config_sha256(config)), files, [], dump_config(config), {})


def prove_tolerance(path: Path, uncertainty: Uncertainty) -> Tolerance:
    """Prove that one calibration error is tolerated."""
    with working_precision(64):
        chain = close_chain(build_problem(path.machine, path, 1e-4, uncertainty))
    assert chain.failure is None
    return Tolerance(uncertainty.length_m, 2.0 * uncertainty.length_m, np.inf, proven_chain(chain, uncertainty))


def check(folder: pathlib.Path) -> Result:
    """Call the command line; an unexpected exception is raised."""
    result = CliRunner().invoke(app, ["certify", "--check", str(folder / CERTIFICATE_JSON)], env={"COLUMNS": "400"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def forge(folder: pathlib.Path, change: Callable[[Data], object]) -> None:
    """Change what a certificate says."""
    file = folder / CERTIFICATE_JSON
    data = json.loads(file.read_bytes())
    change(data)
    file.write_text(json.dumps(data))

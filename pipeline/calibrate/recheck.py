"""Whether the machines that a certificate speaks of are those which a calibration leaves possible."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipeline.calibrate.possible_machines import machine_covariance, probability_within
from pipeline.calibrate.stored import parse_calibration, require_calibrated
from pipeline.certify.recheck import Claim, StatedMachines, Statement
from pipeline.config import MachineConfig
from pipeline.errors import UsageError
from pipeline.inclusion.calibrated.ellipsoid import PARAMETERS, Ellipsoid
from pipeline.refine.result import Path as RefinedPath
from pipeline.regular_file import read_regular_file

FILE = "the calibration is the one that is stated"
MACHINE = "the machine is the one that the calibration found"
COVARIANCE = "its machines are as far off as its covariance says"
PROBABILITY = "the probability of all parameters together is the one that is stated"
_MOST_BYTES = 10_000_000
_ROUNDING = 1e-9
"""Of the largest variance, in units of what was known beforehand."""


def machines_claims(file: Path, machine: MachineConfig, path: RefinedPath, stated: Statement) -> list[Claim]:
    """Verify what a certificate states of machines against the calibration that was kept beside it."""
    chains = [chain.uncertainty.ellipsoid for chain in stated.chains if chain.uncertainty.ellipsoid is not None]
    if stated.machines is None or not chains:
        return []
    return list(_claims(file, machine, path, (stated.machines, chains[0])))


def _claims(
    file: Path, machine: MachineConfig, path: RefinedPath, stated: tuple[StatedMachines, Ellipsoid]
) -> Iterator[Claim]:
    said, ellipsoid = stated
    try:
        stored = parse_calibration(read_regular_file(file, _MOST_BYTES), file.name)
    except (OSError, UsageError) as error:
        yield Claim(FILE, verified=False, found=f"{file.name}: {str(error).splitlines()[0]}")
        return
    same = stored.sha256 == said.calibration_sha256 and said.parameters == stored.parameters.names[:PARAMETERS]
    yield Claim(FILE, same, stored.sha256[:12])
    try:
        model = require_calibrated(stored, machine)
    except UsageError as error:
        yield Claim(MACHINE, verified=False, found=str(error).splitlines()[0])
        return
    units = (model.middles_m + model.zeros_m, model.scales)
    at = (ellipsoid.zero_at_m == units[0]).all() and (ellipsoid.scale == units[1]).all()
    yield Claim(MACHINE, bool(at), f"{len(stored.values)} parameters")
    known = stored.prior_std[:PARAMETERS]
    scale = np.outer(known, known)
    wanted = machine_covariance(stored, model, path) / scale
    with np.errstate(all="ignore"):
        off = np.abs(ellipsoid.factor @ ellipsoid.factor.T / scale - wanted).max()
        close = bool(off <= _ROUNDING * np.abs(wanted).max())
    yield Claim(COVARIANCE, close, f"off by {off:.2g} of what was known beforehand, squared")
    likely = probability_within(ellipsoid)
    near = abs(likely - said.probability) <= 1e-9 * max(likely, 1e-3)
    yield Claim(PROBABILITY, near, f"{likely:.6g}; stated {said.probability:.6g}")

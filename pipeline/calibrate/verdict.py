"""Whether a calibration may be believed, and if not, what is most likely wrong.

The least value of the fit is distributed as chi-square if the model, the noise and what was known beforehand are right.
Where it is too large, models that would explain it are tried: outliers, kinds of parameters that were not fitted.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from pipeline.calibrate.advice import enough_poses, larger_noise, larger_prior
from pipeline.calibrate.calibration import Calibration
from pipeline.calibrate.identify import Identification, Problem, identify, pose_modes
from pipeline.calibrate.model.gauges import fitted_gauges, rank
from pipeline.calibrate.model.parameters import CHOICES, CLOCKS, DIRECTIONS, Kind
from pipeline.calibrate.robust import identify_robustly

_UNLIKELY = 1e-3
"""Probability below which a chi-square means that something is wrong."""


@dataclass(frozen=True)
class Verdict:
    """Whether a calibration may be believed.

    Attributes
    ----------
    accepted : bool
        The data determine the machine, and a machine of this model explains them.
    reasons : tuple of str
        Why not, with what to do.
    chi2, freedom : float, int
        The least value of the fit, and its mean if all is right.
    probability : float
        How often it would be as large by chance.
    directions, gauges, rank, from_data : int
        Directions in which the machine may change; that change nothing that is seen; that change what was seen; of
        which the data say more than was known.
    """

    accepted: bool
    reasons: tuple[str, ...]
    chi2: float
    freedom: int
    probability: float
    directions: int
    gauges: int
    rank: int
    from_data: int


def judge(calibration: Calibration) -> Verdict:
    """Judge a calibration by rank and chi-square."""
    found = calibration.identification
    problem = found.problem
    directions = int(problem.is_fitted.sum())
    gauges = len(fitted_gauges(problem.model, problem.is_fitted))
    reached = rank(problem.data_jacobian(np.zeros_like(found.theta), problem.guess))
    reasons = []
    if reached < directions - gauges:
        reasons.append(_too_few(calibration, reached, directions - gauges))
    probability = _probability(found)
    if probability < _UNLIKELY:
        reasons.append(_unexplained(calibration))
    singular = np.linalg.svd(found.jacobian, compute_uv=False)
    return Verdict(
        accepted=not reasons,
        reasons=tuple(reasons),
        chi2=found.chi2,
        freedom=found.freedom,
        probability=probability,
        directions=directions,
        gauges=gauges,
        rank=reached,
        from_data=int(np.count_nonzero(singular > 1.0)),
    )


def measured_modes(found: Identification) -> dict[str, int]:
    """Count poses by the working mode they were measured in."""
    names, counts = np.unique(pose_modes(found), return_counts=True)
    return dict(zip(names.tolist(), counts.tolist(), strict=True))


def _probability(found: Identification) -> float:
    return float(chi2.sf(found.chi2, found.freedom))


def _is_believed(found: Identification) -> bool:
    return _probability(found) > _UNLIKELY


def _too_few(calibration: Calibration, reached: int, needed: int) -> str:
    modes = ", ".join(f"{count} {name}" for name, count in measured_modes(calibration.identification).items())
    count = enough_poses(calibration, needed)
    suffice = "" if count is None else f": the {count} of --next {count} suffice"
    return (
        f"the poses determine {reached} of the {needed} directions that measurements can tell.\n"
        "  What to change: measure more poses, differently tilted and in more working modes (there are "
        f"{modes}){suffice}; or fit less (--fit)."
    )


def _unexplained(calibration: Calibration) -> str:
    """Say what explains the data better than the machine that was fitted."""
    found = calibration.identification
    problem = found.problem
    said = (
        f"no machine explains the measurement: chi-square is {found.chi2:,.0f}, expected are {found.freedom:,} "
        f"(by chance so large once in {_once(_probability(found))})."
    )
    unfitted = [kind for kind in CHOICES if kind not in calibration.setting.fit]
    if CLOCKS.key in unfitted and (explained := _with_kind(problem, CLOCKS.key)):  # else robust fits may take minutes
        return f"{said} {explained}"
    if not calibration.setting.robust:
        robust, rejected = identify_robustly(problem)
        if _is_believed(robust):
            places = [problem.poses.place(int(row)) for row in np.flatnonzero(rejected.any(axis=1))]
            shown = "; ".join(places[:5]) + (f" and {len(places) - 5} more" if len(places) > 5 else "")
            return f"{said} {rejected.sum()} points are outliers ({shown}).\n  What to change: --robust rejects them."
    for kind in unfitted:
        if kind != CLOCKS.key and (explained := _with_kind(problem, kind)):
            return f"{said} {explained}"
    if found.data_chi2 < chi2.isf(_UNLIKELY, found.data_freedom):
        std = larger_prior(problem, _is_believed)
        tried = "--prior, --reflector-std" if std is None else f"--prior {std:g}, with which one does"
        return (
            f"{said} The machine is farther from the configuration than was thought beforehand.\n"
            f"  What to change: give larger deviations ({tried})."
        )
    noise = problem.noise_m * np.sqrt(found.data_chi2 / found.data_freedom)
    enough = larger_noise(found, _is_believed)
    given = "--noise" if enough is None else f"--noise {enough:g}, with which one does"
    return (
        f"{said} Residuals are those of a noise of {1e6 * noise:.0f} um, instead of {1e6 * problem.noise_m:.0f} um.\n"
        f"  What to change: give the noise as it is ({given}); --robust if some points are wrong; check that the "
        "machine stood still, and that q1_m to q5_m are what its encoders showed."
    )


def _with_kind(problem: Problem, kind: str) -> str:
    """Say what explains the data if one more kind is fitted; nothing if that does not."""
    wider = replace(problem, is_fitted=problem.is_fitted | problem.model.parameters.is_fitted((kind,)))
    if (wider.is_fitted == problem.is_fitted).all():
        return ""
    other = identify(wider)
    return _explained_by(kind, other) if _is_believed(other) else ""


def _explained_by(key: str, found: Identification) -> str:
    if key == CLOCKS.key:
        late = ", ".join(f"{1e3 * late_s:+.3f} ms" for late_s in found.model.clocks_s)
        return (
            f"Clocks that differ do: the tracker's is late by {late}, within {1e3 * _std(found, CLOCKS):.3f} ms.\n"
            "  What to change: add clocks to --fit; measure static poses, which need no clock."
        )
    if key != DIRECTIONS.key:
        return f"With {key} fitted, one does.\n  What to change: add {key} to --fit."
    slopes = found.model.directions_rad
    listed = ", ".join(f"rail {arm + 1} ({1e3 * y:+.3f}, {1e3 * z:+.3f})" for arm, (y, z) in enumerate(slopes))
    return (
        f"Rails that are not parallel do: slopes along Y and Z in mrad are {listed}, each within "
        f"{1e3 * _std(found, DIRECTIONS):.3f}.\n"
        "  What to change: add directions to --fit, or align the rails."
    )


def _std(found: Identification, kind: Kind) -> float:
    return float(found.model.parameters.of(kind, found.std).max())


def _once(probability: float) -> str:
    return f"{1.0 / probability:,.0f}" if probability > 1e-9 else "more than 1,000,000,000"

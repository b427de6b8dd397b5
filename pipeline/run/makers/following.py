"""Make the table of following errors: after the proof, and again once the motion is known."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pipeline.artifacts import read_state
from pipeline.artifacts.layout import CERTIFICATE_JSON
from pipeline.artifacts.results.following import following_files
from pipeline.certify.following import COMMON
from pipeline.certify.following.steps import FollowingProfile, following_profile
from pipeline.run.up_to_date.check import why_outdated
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.arrays import FloatArray
    from pipeline.retime.result import Trajectory
    from pipeline.run.results import Results

_HALVINGS = 60


def table_of_proof(results: "Results", profile: FollowingProfile | None) -> dict[str, bytes]:
    """Write the table of what was just proven, with the times of a trajectory that is still that of the path."""
    if profile is None:
        return {}
    state = read_state(results.folder)
    records = {} if state is None else state.stages
    outdated = why_outdated(results.specs, Stage.RETIME, results.config, records, results.folder)
    return following_files(profile, None if outdated else times_at(results.trajectory, profile.s))


def table_of_motion(results: "Results", trajectory: "Trajectory") -> dict[str, bytes]:
    """Write the table once more, with the times of a trajectory that was just made; nothing if none was proven."""
    profile = proven_following(results)
    return {} if profile is None else following_files(profile, times_at(trajectory, profile.s))


def proven_following(results: "Results") -> FollowingProfile | None:
    """Give the proven following errors over s; None if they were not searched."""
    if not (results.folder / CERTIFICATE_JSON).exists():
        return None
    certificate = results.certificate
    if (profile := following_profile(certificate.chains)) is None:
        return None
    stated = (certificate.following.within_limits, certificate.following.on_branch)
    stops = (None if COMMON not in one else one[COMMON].stopped_by for one in stated)
    return replace(profile, stops=tuple(stop for stop in stops if stop is not None))


def times_at(trajectory: "Trajectory", s: "FloatArray") -> "FloatArray":
    """Find when a trajectory is at some s (n,), by bisection."""
    early, late = np.zeros(len(s)), np.full(len(s), trajectory.duration_s)
    for _ in range(_HALVINGS):
        middle = (early + late) / 2.0
        before = trajectory.s(middle) < s
        early, late = np.where(before, middle, early), np.where(before, late, middle)
    return late

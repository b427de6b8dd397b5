"""What a stage's result is made from, as one hash: as long as it stays, the result stays good."""

import functools
import hashlib
import pathlib
from collections.abc import Mapping
from typing import Any

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.stage import Stage
from pipeline.summary.sections import package_version

UPSTREAM: dict[Stage, tuple[Stage, ...]] = {
    Stage.REGIONS: (),
    Stage.ROUTE: (Stage.REGIONS,),
    Stage.REFINE: (Stage.ROUTE,),
    Stage.CERTIFY: (Stage.REFINE,),
    Stage.RETIME: (Stage.REFINE,),
    Stage.FIGURES: (Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY, Stage.RETIME),
}
"""The stages whose results a stage is given."""

_BASE = ("arrays.py", "parallel.py", "artifacts", "machine")
_CODE = {
    Stage.REGIONS: (*_BASE, "route"),
    Stage.ROUTE: (*_BASE, "solvers", "route"),
    Stage.REFINE: (*_BASE, "solvers", "route", "refine"),
    Stage.CERTIFY: (*_BASE, "route", "refine", "inclusion", "certify"),
    Stage.RETIME: (*_BASE, "solvers", "route", "refine", "retime", "export"),
    Stage.FIGURES: (
        *_BASE,
        *("solvers", "route", "refine", "inclusion", "certify", "retime", "export", "measured", "compare"),
        *("workspace", "figures", "report", "summary"),
    ),
}
PROOFS = ("nothing", "path", "tolerances")
"""What `certify.what` may be; each proves what those before it do."""
_TOLERANCES_ONLY = ("tolerance_resolution", "monte_carlo_samples")
"""Keys of the proof that only the search for tolerances reads."""
_MOTION_ONLY = ("limits", "dynamics")
"""Parts of the machine that only its motion in time depends on."""
_PACKAGE = pathlib.Path(__file__).parents[1]


def config_part(config: Config, stage: Stage) -> dict[str, Any]:
    """Pick the keys of the configuration that a stage may read.

    Stages one and two know nothing of limits and masses, so that others cost a new trajectory only. The files of
    later stages quote the configuration, name and hash included, so that they depend on all of it.
    """
    whole = config.model_dump(mode="json")
    machine = {key: value for key, value in whole["machine"].items() if key not in _MOTION_ONLY}
    space = {"machine": machine, "task": whole["task"]}
    if stage is Stage.REGIONS:
        # The margin around boxes to avoid is counted in steps.
        margin = ("avoid_margin", "x_step_m") if config.task.avoid else ()
        route = {key: whole["route"][key] for key in ("grid", "kappa_max", *margin)}
        task = {key: value for key, value in whole["task"].items() if key != "budget"}
        return {"machine": machine, "task": task, "route": route}
    if stage is Stage.ROUTE:
        return {**space, "route": whole["route"]}
    if stage is Stage.REFINE:
        return {**space, "route": whole["route"], "refine": whole["refine"]}
    if stage is Stage.CERTIFY:
        unread = () if config.certify.what == "tolerances" else _TOLERANCES_ONLY
        certify = {key: value for key, value in whole["certify"].items() if key not in unread}
        return {**space, "route": whole["route"], "refine": whole["refine"], "certify": certify}
    return whole


def grid_fingerprint(config: Config) -> str:
    """Hash all that the regions of grid and gates depend on: start, goal, name and limits are none of it."""
    space = config_part(config, Stage.REGIONS)
    return config_sha256(
        {
            "machine": space["machine"],
            "task": {key: space["task"][key] for key in ("tilt_max_deg", "locked_axes")},
            "route": {key: space["route"][key] for key in ("grid", "kappa_max")},
            "version": package_version(),
            "code": [_code_sha256(package) for package in _CODE[Stage.REGIONS]],
        }
    )


def fingerprint(config: Config, stage: Stage, upstream: Mapping[Stage, str]) -> str:
    """Hash a stage's part of the configuration, the results it is given, the package's version and its code.

    The code counts because a working copy changes far more often than its version does.

    Parameters
    ----------
    upstream : mapping
        Hash of the result of every stage in `UPSTREAM`.
    """
    # The boxes of a certificate follow from path, configuration and code; the report alone reads what else it tells.
    counting = [name for name in UPSTREAM[stage] if name is not Stage.CERTIFY or stage is Stage.FIGURES]
    return config_sha256(
        {
            "stage": stage,
            "config": config_part(config, stage),
            "upstream": {name: upstream[name] for name in counting},
            "version": package_version(),
            "code": [_code_sha256(package) for package in _CODE[stage]],
        }
    )


def fingerprints(config: Config, stage: Stage, upstream: Mapping[Stage, str]) -> list[str]:
    """All fingerprints an up-to-date result may have: a certificate may prove more than is asked for."""
    if stage is not Stage.CERTIFY:
        return [fingerprint(config, stage, upstream)]
    enough = PROOFS[PROOFS.index(config.certify.what) :]
    return [fingerprint(with_proof(config, what), stage, upstream) for what in enough]


def with_proof(config: Config, what: str) -> Config:
    """Ask for another proof, one of `PROOFS`."""
    return config.model_copy(update={"certify": config.certify.model_copy(update={"what": what})})


@functools.cache
def _code_sha256(part: str) -> str:
    """Hash a package within this one, or a module."""
    digest, home = hashlib.sha256(), _PACKAGE / part
    # Templates, styles and scripts are code, too.
    files = [home] if home.is_file() else [file for file in home.rglob("*") if file.is_file()]
    for source in sorted(file for file in files if "__pycache__" not in file.parts):
        digest.update(source.relative_to(_PACKAGE).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()

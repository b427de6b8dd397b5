"""Make the corrected path."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.artifacts.layout import CORRECTION_CSV
from pipeline.artifacts.results.columns import CONTROLLED_COLUMNS, split_columns
from pipeline.config import MachineConfig
from pipeline.correct.correction import STAGE, Correction, correct_path, poses_as_driven
from pipeline.correct.errors import PoseErrors, pose_errors
from pipeline.correct.reach import reach_gaps
from pipeline.errors import NoSolutionError
from pipeline.export.csv import format_csv
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import ACTUATORS
from pipeline.progress import Monitor
from pipeline.refine.check import find_broken
from pipeline.refine.measure import measure_kappa, sample_path
from pipeline.refine.requirements import own_requirements
from pipeline.refine.result import Refinement
from pipeline.route.metric import step_sizes
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.run.makers.path import path_product
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.status import Status
from pipeline.summary.path import CORRECTION, path_words
from pipeline.summary.section import Section

if TYPE_CHECKING:
    from pipeline.arrays import FloatArray
    from pipeline.run.results import Results

_MEASURED = 5_001
_CHANGES = tuple(f"d{name}_m" for name in ACTUATORS)


@dataclass(frozen=True, eq=False)
class Planned:
    """What is corrected: a refined path, and the configuration of the machine that it was planned for."""

    refinement: Refinement
    machine: MachineConfig


def make_corrected(results: "Results", monitor: Monitor) -> Product:
    """Correct the planned path for the machine of this run, and check it against all limits of paths."""
    config, planned = results.config, results.given[Stage.REFINE]()
    before, after = controller_units(planned.machine), controller_units(config.machine)
    monitor.progress("correcting the path")
    s = np.linspace(0.0, 1.0, _MEASURED)
    path = planned.refinement.path
    driven = poses_as_driven(path, results.machine, lambda q_m: after.to_geometry(before.to_controller(q_m)), s)
    start, goal = (end.q_m for end in task_endpoints(config, results.machine))
    correction = correct_path(path, results.machine, (start, goal))
    monitor.progress("checking the corrected path")
    required = own_requirements(config, correction.path)
    if broken := find_broken(correction.path, required, config.refine.check_points):
        raise NoSolutionError(
            STAGE,
            f"the corrected path breaks limits of the calibrated machine: {'; '.join(map(str, broken))}",
            "Plan again for this machine (--plan-again DIR).",
        )
    planned_pose, reached = path.pose(s), correction.path.pose(s)
    errors = pose_errors(s, driven, planned_pose), pose_errors(s, reached, planned_pose)
    product = path_product(results, _refinement(planned.refinement, correction, results))
    gaps = reach_gaps(path, results.machine, s, reached)
    facts = {
        "before": errors[0].as_json(),
        "after": errors[1].as_json(),
        "change_m": np.abs(correction.change_m(s)).max(axis=0).tolist(),
        "mode_changes": [gap._asdict() for gap in gaps],
        "evaluations": correction.evaluations,
    }
    files = {**product.files, CORRECTION_CSV: _table(correction, *errors).encode()}
    return Product(files, {**product.section, CORRECTION: facts})


def _refinement(planned: Refinement, correction: Correction, results: "Results") -> Refinement:
    """Put the corrected path where refined ones are; the coarse one is the route as planned, on this machine."""
    path = correction.path
    integral = measure_kappa(sample_path(path, path.node_s), step_sizes(results.config.route)).kappa_integral
    return replace(
        planned,
        path=path,
        coarse=replace(planned.coarse, machine=results.machine),
        status=Status.CONVERGED,
        iterations=correction.evaluations,
        rounds=1,
        meshes=1,
        mesh_change=None,
        surrogate_integral=integral,
    )


def _table(correction: Correction, before: PoseErrors, after: PoseErrors) -> str:
    """Write dq over s, in the geometry, and errors against the planned poses, uncorrected and corrected."""
    columns: dict[str, FloatArray] = {"s": after.s, **split_columns(_CHANGES, correction.change_m(after.s))}
    for name, errors in (("before", before), ("after", after)):
        columns |= split_columns(tuple(f"{name}_{column}" for column in CONTROLLED_COLUMNS), errors.error)
    return format_csv(columns)


def corrected_words(section: Section) -> str:
    """Say the key figures in words."""
    facts: dict[str, Any] = section[CORRECTION]
    rms, largest = (1e3 * facts["after"][key] for key in ("rms_m", "largest_m"))
    return f"off the planned poses by {rms:.3f} mm rms, {largest:.3f} mm at most; {path_words(section)}"

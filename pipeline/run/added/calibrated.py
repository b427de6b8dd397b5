"""The proof for every machine that a calibration leaves possible, added to the certificate of a run."""

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from pipeline.artifacts import Record, State, jsonable, open_run_folder
from pipeline.artifacts.layout import CALIBRATION_JSON, CERTIFICATE_JSON, CONFIG
from pipeline.artifacts.results.certificate.json_text import read_certificate_json
from pipeline.artifacts.results.certificate.stored import with_machines
from pipeline.calibrate.possible_machines import possible_machines, probability_within, sigma_of
from pipeline.calibrate.stored import StoredCalibration
from pipeline.certify.machines.calibrated import CalibratedProof, prove_calibrated
from pipeline.certify.recheck import StatedMachines
from pipeline.certify.recheck.claims.machines import beyond_range
from pipeline.certify.result import path_sha256
from pipeline.errors import NoSolutionError, UsageError
from pipeline.inclusion.calibrated.ellipsoid import PARAMETERS, Ellipsoid
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path as RefinedPath
from pipeline.run.reading import open_results
from pipeline.run.results import Results
from pipeline.run.stage_specs import SPECS
from pipeline.stage import Stage
from pipeline.summary.certificate import machines_part
from pipeline.summary.whole import summarise


@dataclass(frozen=True)
class Wanted:
    """How many machines are asked for: by deviations of every combination, or by the probability of all together."""

    sigma: float | None = None
    probability: float | None = None


_THREE = Wanted(sigma=3.0)


@dataclass(frozen=True, eq=False)
class AddedProof:
    """What was proven, and what is stated of it."""

    stated: StatedMachines
    proof: CalibratedProof


def certify_calibrated(
    folder: Path, calibration: StoredCalibration, wanted: Wanted = _THREE, monitor: Monitor = QUIET
) -> AddedProof:
    """Prove the path of a run for every machine that a calibration leaves possible, and add that to its certificate.

    Raises
    ------
    UsageError
        When the folder is no finished run with a certificate, or its machine is not the calibrated one.
    NoSolutionError
        When the motion is not proven to stay on one branch for all of these machines: where, and why.
    """
    results = open_results(folder, Stage.REFINE, Stage.CERTIFY)
    if not (folder / CERTIFICATE_JSON).exists():
        raise UsageError(
            f"{folder} has no certificate: certify.what is nothing.\n"
            "  What to change: gantry-tau certify CONFIG, with certify.what: path."
        )
    path = results.refinement.path
    _require_of_path(folder, results.certificate.path_sha256, path)
    machines = possible_machines(calibration, results.config.machine, path, wanted.sigma or 1.0)
    if wanted.probability is not None:
        sigma = sigma_of(wanted.probability, machines.factor.shape[1])
        machines = possible_machines(calibration, results.config.machine, path, sigma)
    proof = prove_calibrated(results.config, results.machine, path, machines, monitor)
    if proof.chain is None:
        raise _refusal(proof, machines)
    stated = _stated(results, calibration, machines, proof)
    _add(results, calibration, stated, proof)
    return AddedProof(stated, proof)


def _require_of_path(folder: Path, stated_sha256: object, path: RefinedPath) -> None:
    if stated_sha256 != path_sha256(path):
        raise UsageError(f"the certificate in {folder} is of another path.\n  What to change: run the pipeline again.")


def _stated(
    results: Results, calibration: StoredCalibration, machines: Ellipsoid, proof: CalibratedProof
) -> StatedMachines:
    assert proof.chain is not None
    reserves = proof.reserves.tilt_deg, proof.reserves.actuators_m
    beyond = beyond_range(results.config, results.machine, results.certificate.bounds, reserves)
    return StatedMachines(
        sigma=machines.sigma,
        dimensions=machines.factor.shape[1],
        probability=probability_within(machines),
        boxes=len(proof.chain.boxes),
        within_limits=proof.chain.within_limits,
        calibration_sha256=calibration.sha256,
        parameters=calibration.parameters.names[:PARAMETERS],
        tilt_reserve_deg=proof.reserves.tilt_deg,
        actuator_reserve_m=proof.reserves.actuators_m,
        ranges_kept=not beyond,
    )


def _add(results: Results, calibration: StoredCalibration, stated: StatedMachines, proof: CalibratedProof) -> None:
    """Write the certificate with one more chain, and the calibration beside it, in one step."""
    assert proof.chain is not None
    folder = results.folder
    with open_run_folder(folder) as opened:
        open_results(folder, Stage.REFINE, Stage.CERTIFY)
        data = read_certificate_json(folder / CERTIFICATE_JSON)
        _require_of_path(folder, data.get("path_sha256"), results.refinement.path)
        files = {
            CERTIFICATE_JSON: with_machines(data, stated, proof.chain),
            CALIBRATION_JSON: calibration.content,
        }
        record = _with(opened.state.stages[Stage.CERTIFY], files, stated)
        records = {**opened.state.stages, Stage.CERTIFY: record}
        sections = {
            spec.section: spec.in_summary(records[spec.stage].summary if spec.stage in records else None)
            for spec in SPECS
        }
        state = State(config_sha256=opened.state.config_sha256, stages=records)
        text = (folder / CONFIG).read_text(encoding="utf-8")
        opened.change(state, files, [], text, summarise(results.config, sections))


def _with(record: Record, files: Mapping[str, bytes], stated: StatedMachines) -> Record:
    """Record the certificate as it is now."""
    changes = {
        "files": {**record.files, **{name: sha256(content).hexdigest() for name, content in files.items()}},
        "sizes": {**record.sizes, **{name: len(content) for name, content in files.items()}},
        "summary": {**record.summary, **jsonable(machines_part(stated))},
    }
    return record.model_copy(update=changes)


def _refusal(proof: CalibratedProof, machines: Ellipsoid) -> NoSolutionError:
    assert proof.failure is not None
    return NoSolutionError(
        "certify",
        f"the motion is not proven for every machine within {machines.sigma:g} deviations of the calibration, beyond s "
        f"= {proof.failure.s:.6f}: {proof.failure.reason.text}",
        "Measure more poses (gantry-tau calibrate --next), so that less is possible, or ask for fewer deviations "
        "(--sigma).",
        {"status": "not certified", "s": proof.failure.s},
    )

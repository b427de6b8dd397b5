"""The proof for every machine that a calibration leaves possible, from a run's folder to what `--check` says of it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from pipeline.artifacts.layout import CALIBRATION_JSON, CERTIFICATE_JSON, SUMMARY
from pipeline.artifacts.results.certificate.stored import read_certificate
from pipeline.calibrate.recheck import COVARIANCE, FILE, MACHINE, PROBABILITY
from pipeline.calibrate.stored import read_calibration
from pipeline.certify.recheck.claims.errors import WITHIN_LIMITS
from pipeline.certify.recheck.claims.inventory import MACHINES
from pipeline.certify.recheck.claims.machines import RANGES, RESERVE
from pipeline.cli import app
from pipeline.errors import NoSolutionError, UsageError
from pipeline.run.added.calibrated import Wanted, certify_calibrated
from tests.certify.runs import check, forge
from tests.certify.test_check import refused
from tests.run.added.conftest import CalibratedRun

Data = dict[str, Any]


def _call(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["certify", *map(str, arguments)], env={"COLUMNS": "300"})


@pytest.fixture(scope="module")
def proven(true_run: CalibratedRun, tmp_path_factory: pytest.TempPathFactory) -> CalibratedRun:
    """Prove the run for three standard deviations."""
    run = true_run.copied(tmp_path_factory.mktemp("proven"))
    result = _call(run.folder, "--calibration", run.calibration)
    assert result.exit_code == 0, result.output
    assert "every machine within 3 standard deviations of every combination" in result.output
    return run


@pytest.fixture
def proven_copy(proven: CalibratedRun, tmp_path: Path) -> CalibratedRun:
    """Give a copy, to be forged."""
    return proven.copied(tmp_path)


def test_the_proof_is_in_the_certificate_and_verified(proven: CalibratedRun) -> None:
    """With the calibration beside it, the rest of the certificate as it was, and its figures in the summary."""
    stated = read_certificate(proven.folder / CERTIFICATE_JSON)
    assert stated.machines is not None
    assert (stated.machines.sigma, stated.machines.within_limits, len(stated.chains)) == (3.0, True, 2)
    assert 0.0 < stated.machines.probability < 1e-6
    assert (proven.folder / CALIBRATION_JSON).read_bytes() == proven.calibration.read_bytes()
    section = json.loads((proven.folder / SUMMARY).read_bytes())["certificate"]
    assert section["calibrated_sigma"] == 3.0
    assert section["calibrated_boxes"] == stated.machines.boxes
    result = check(proven.folder)
    assert result.exit_code == 0, result.output
    for claim in (FILE, MACHINE, COVARIANCE, PROBABILITY, MACHINES, RANGES, RESERVE, WITHIN_LIMITS):
        assert claim in result.stdout


def test_another_proof_takes_the_place_of_the_first(proven_copy: CalibratedRun) -> None:
    """By a probability of all parameters together."""
    result = _call(proven_copy.folder, "--calibration", proven_copy.calibration, "--probability", 0.9973)
    assert result.exit_code == 0, result.output
    stated = read_certificate(proven_copy.folder / CERTIFICATE_JSON)
    assert stated.machines is not None
    assert len(stated.chains) == 2
    assert stated.machines.sigma > 8.0
    np.testing.assert_allclose(stated.machines.probability, 0.9973, rtol=1e-9)
    assert check(proven_copy.folder).exit_code == 0


def _machines(data: Data) -> Data:
    return data["tolerances"]["machines"]


def _ellipsoid(data: Data) -> Data:
    return data["chains"][-1]["uncertainty"]["ellipsoid"]


def _scale_factor(data: Data) -> None:
    one = _ellipsoid(data)
    one["factor"] = [[0.9 * value for value in row] for row in one["factor"]]


def _change_k(data: Data) -> None:
    _machines(data)["sigma"] = 4.0


def _change_k_everywhere(data: Data) -> None:
    _machines(data)["sigma"] = _ellipsoid(data)["sigma"] = 60.0


def _drop_a_box(data: Data) -> None:
    chain = data["chains"][-1]
    for key in ("pose", "radius"):
        del chain[key][1]
    for key in ("s", "joint_pose", "joint_radius"):
        del chain[key][1]
    _machines(data)["boxes"] -= 1


def _drop_the_chain(data: Data) -> None:
    del data["chains"][-1]


def _another_hash(data: Data) -> None:
    _machines(data)["calibration_sha256"] = "0" * 64


def _other_encoders(data: Data) -> None:
    _ellipsoid(data)["zero_at_m"][0] += 1e-3


def _likelier(data: Data) -> None:
    _machines(data)["probability"] = 0.9973


def _less_reserve(data: Data) -> None:
    _machines(data)["actuator_reserve_m"][0] *= 0.9


def _other_names(data: Data) -> None:
    names = _machines(data)["parameters"]
    names[0], names[1] = names[1], names[0]


def _narrower_boxes(data: Data) -> None:
    chain = data["chains"][-1]
    chain["radius"] = [[0.5 * value for value in row] for row in chain["radius"]]


def _unstated(data: Data) -> None:
    del data["tolerances"]["machines"]


@pytest.mark.parametrize(
    ("change", "claim"),
    [
        (_scale_factor, COVARIANCE),
        (_change_k, MACHINES),
        (_change_k_everywhere, "each box holds one regular pose"),
        (_drop_a_box, "each box holds one regular pose"),
        (_drop_the_chain, MACHINES),
        (_another_hash, FILE),
        (_other_names, FILE),
        (_other_encoders, MACHINE),
        (_likelier, PROBABILITY),
        (_less_reserve, RESERVE),
        (_narrower_boxes, "each box holds one regular pose"),
        (_unstated, MACHINES),
    ],
)
def test_forged_proofs_are_refused(proven_copy: CalibratedRun, change: Callable[[Data], None], claim: str) -> None:
    """Whatever is changed, and for the claim that it breaks."""
    forge(proven_copy.folder, change)
    result = check(proven_copy.folder)
    assert result.exit_code == 1
    assert any(claim in one for one in refused(result)), result.output


def test_another_calibration_beside_it_is_refused(proven_copy: CalibratedRun) -> None:
    """One that knows everything twice as well, and one that is missing."""
    file = proven_copy.folder / CALIBRATION_JSON
    data = json.loads(file.read_bytes())
    data["covariance"] = [[value / 4.0 for value in row] for row in data["covariance"]]
    file.write_text(json.dumps(data))
    result = check(proven_copy.folder)
    assert result.exit_code == 1
    assert {FILE, COVARIANCE} <= set(refused(result))
    file.unlink()
    assert check(proven_copy.folder).exit_code == 1


def test_an_uncalibrated_machine_is_not_proven(calibrated_run: CalibratedRun) -> None:
    """With nothing but what was known beforehand, and a hundred times that: exit code 1, and nothing is written."""
    data = json.loads(calibrated_run.calibration.read_bytes())
    prior = [1.0 if row["prior_std"] is None else 100.0 * row["prior_std"] for row in data["parameters"]]
    fitted = {row["name"] for row in data["parameters"] if row["source"] != "not fitted"}
    std = [p if row["name"] in fitted else 0.0 for p, row in zip(prior, data["parameters"], strict=True)]
    data["covariance"] = np.diag(np.square(std)).tolist()
    calibrated_run.calibration.write_text(json.dumps(data))
    before = (calibrated_run.folder / CERTIFICATE_JSON).read_bytes()
    result = _call(calibrated_run.folder, "--calibration", calibrated_run.calibration)
    assert result.exit_code == 1
    assert isinstance(result.exception, NoSolutionError | SystemExit)
    assert (calibrated_run.folder / CERTIFICATE_JSON).read_bytes() == before
    assert not (calibrated_run.folder / CALIBRATION_JSON).exists()


def test_too_many_deviations_are_refused(calibrated_run: CalibratedRun) -> None:
    """With where, why and what to do."""
    with pytest.raises(NoSolutionError, match="every machine within 1000 deviations"):
        certify_calibrated(calibrated_run.folder, read_calibration(calibrated_run.calibration), Wanted(sigma=1000.0))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--sigma", "3"), "go with --calibration"),
        (("--calibration", "real.json", "--sigma", "3", "--probability", "0.9"), "--sigma or --probability alone"),
        (("--calibration", "real.json", "--force"), "goes with a run folder"),
        (("--calibration", "nowhere.json"), "nowhere.json cannot be read"),
    ],
)
def test_options_that_do_not_go_together_are_refused(options: tuple[str, ...], said: str) -> None:
    """Before anything is read."""
    result = _call("run", *options)
    assert result.exit_code == 2 or isinstance(result.exception, UsageError)
    assert said in result.output or said in str(result.exception)


def test_a_machine_that_is_not_the_calibrated_one_is_refused(calibrated_run: CalibratedRun) -> None:
    """A micrometre in one number, named with both values."""
    data = json.loads(calibrated_run.calibration.read_bytes())
    data["parameters"][0]["change"] += 1e-6
    calibrated_run.calibration.write_text(json.dumps(data))
    with pytest.raises(UsageError, match=r"platform joint 1 x is .*calibrated .*1 of"):
        certify_calibrated(calibrated_run.folder, read_calibration(calibrated_run.calibration))

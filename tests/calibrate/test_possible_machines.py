"""The machines that a calibration leaves possible: of its covariance, in frames that the path's closures choose."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from pipeline.artifacts import json_bytes
from pipeline.calibrate import (
    DrivenMotion,
    Setting,
    StaticPoses,
    StaticSetting,
    calibrate,
    calibrated_yaml,
    judge,
    simulate_motion,
    simulate_static,
)
from pipeline.calibrate.model.forward import by_parameters, close
from pipeline.calibrate.model.gauges import fitted_frames, fitted_gauges
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.possible_machines import machine_covariance, possible_machines, probability_within, sigma_of
from pipeline.calibrate.report import calibration_data
from pipeline.calibrate.stored import StoredCalibration, parse_calibration, require_calibrated
from pipeline.config import Config
from pipeline.config.file import dump_config, parse_config
from pipeline.errors import UsageError
from pipeline.inclusion.calibrated.ellipsoid import PARAMETERS
from pipeline.machine import build_machine
from pipeline.refine.result import Path
from pipeline.yaml_text import parse_yaml
from tests.calibrate.conftest import REFLECTORS_M, Seen
from tests.calibrate.test_motions import joined
from tests.certify.paths import START, pose_path


@dataclass(frozen=True, eq=False)
class Known:
    """A calibration as it is stored, the machine that it found, and a short path of it."""

    data: dict[str, Any]
    stored: StoredCalibration
    config: Config
    model: Model
    path: Path


@pytest.fixture(scope="module")
def known(quick_config: Config, see: Callable[..., Seen]) -> Known:
    """Calibrate with 40 poses and two reflectors."""
    return _known(quick_config, see(poses=40).simulated.poses)


def _known(quick_config: Config, poses: StaticPoses) -> Known:
    found = calibrate(quick_config, REFLECTORS_M[:2], poses, Setting())
    data = json.loads(json_bytes(calibration_data(found, judge(found))))
    text = calibrated_yaml(dump_config(quick_config), quick_config, found.identification.model, "Calibrated.")
    config = parse_config(parse_yaml(text))
    goal = np.array([1.05, 0.33, 0.88, 0.04, -0.02])
    path = pose_path(build_machine(config.machine), np.linspace(START, goal, 8), 0, nodes=8)
    stored = parse_calibration(json_bytes(data), "real.json")
    return Known(data, stored, config, require_calibrated(stored, config.machine), path)


def test_the_factor_is_one_of_the_covariance(known: Known) -> None:
    """W W' is the covariance of the machine in its frames, and no direction is there for nothing."""
    machines = possible_machines(known.stored, known.config.machine, known.path, 3.0)
    S = machine_covariance(known.stored, known.model, known.path)
    np.testing.assert_allclose(machines.factor @ machines.factor.T, S, atol=1e-9 * S.max())
    fitted = int((known.stored.is_fitted & np.isfinite(known.stored.prior_std))[:PARAMETERS].sum())
    assert fitted - 10 <= machines.factor.shape[1] <= fitted
    np.testing.assert_allclose(machines.zero_at_m, known.model.middles_m + known.model.zeros_m)


def test_frames_change_nothing_that_is_seen_and_are_gauges(known: Known) -> None:
    """Ten of them without directions of rails; uncertain only by what was known beforehand."""
    frames, gauges = (found(known.model, known.stored.is_fitted) for found in (fitted_frames, fitted_gauges))
    assert len(frames) == 10
    np.testing.assert_allclose(frames @ gauges.T @ gauges, frames, atol=1e-9)
    kept = known.stored.is_fitted & np.isfinite(known.stored.prior_std)
    units = known.stored.prior_std[kept]
    N = np.linalg.qr((frames[:, kept] / units).T)[0]
    S = known.stored.covariance[np.ix_(kept, kept)] / np.outer(units, units)
    np.testing.assert_allclose(S @ N, N, atol=1e-6)


def test_closures_along_the_path_hardly_change_by_frames(known: Known) -> None:
    """They change a third as much as with the covariance as it is; parameters do not change more for that."""
    stored, model, path = known.stored, known.model, known.path
    q_m = model.to_encoders(path.q(np.linspace(0.0, 1.0, 101)))
    F = by_parameters(model, q_m, close(model, q_m, path.pose(np.linspace(0.0, 1.0, 101))))
    F, raw = F[..., :PARAMETERS].reshape(-1, PARAMETERS), stored.covariance[:PARAMETERS, :PARAMETERS]
    S, scale = machine_covariance(stored, model, path), stored.prior_std[:PARAMETERS]
    assert np.trace(F @ S @ F.T) < 0.1 * np.trace(F @ raw @ F.T)
    assert (np.diagonal(S) < 4.0 * scale**2).all()


def test_what_reflectors_cannot_tell_of_the_machine_itself_is_kept(known: Known) -> None:
    """A rail against the joints on its cart: as uncertain as it was beforehand."""
    S = machine_covariance(known.stored, known.model, known.path)
    rail, offsets = 36, [18 + 1]
    against = np.zeros(PARAMETERS)
    against[rail], against[offsets] = 1.0, -1.0
    assert np.sqrt(against @ S @ against) > 0.5 * known.stored.prior_std[rail]


@pytest.mark.parametrize("dimensions", [1, 49])
def test_probabilities_and_deviations_belong_together(known: Known, dimensions: int) -> None:
    """One parameter is within three deviations 99.73 % of the time, many together hardly ever."""
    machines = possible_machines(known.stored, known.config.machine, known.path, 3.0)
    machines = replace(machines, factor=machines.factor[:, :dimensions])
    probability = probability_within(machines)
    assert probability == pytest.approx(0.9973002, abs=1e-6) if dimensions == 1 else probability < 1e-6
    assert sigma_of(probability, dimensions) == pytest.approx(3.0, rel=1e-6)


def _of_directions(data: dict[str, Any]) -> None:
    k = next(k for k, row in enumerate(data["parameters"]) if row["name"].startswith("direction"))
    data["covariance"][k][k] = 1e-8


def test_rails_of_any_direction_are_refused(known: Known) -> None:
    """The chain has parallel ones."""
    data = json.loads(json.dumps(known.data))
    _of_directions(data)
    with pytest.raises(UsageError, match="directions of rails were fitted"):
        require_calibrated(parse_calibration(json_bytes(data), "real.json"), known.config.machine)


@pytest.mark.parametrize("slope", [1e-9, 0.003])
def test_a_machine_whose_rails_are_off_x_is_refused(known: Known, slope: float) -> None:
    """However little they are, where the calibration has no directions of its own."""
    rails = known.config.machine.rails
    machine = known.config.machine.model_copy(
        update={"rails": (rails[0].model_copy(update={"slopes": (0.0, slope)}), *rails[1:])}
    )
    with pytest.raises(UsageError, match=r"off X \(machine.rails.slopes\)"):
        require_calibrated(known.stored, machine)


def test_clocks_of_motions_say_nothing_of_the_machine(quick_config: Config, driven: DrivenMotion, known: Known) -> None:
    """A calibration from poses and a motion, whose clock offset is among its parameters, leaves less possible."""
    setting = StaticSetting(poses=40)
    still = simulate_static(quick_config, REFLECTORS_M[:2], setting).poses
    moving = simulate_motion(quick_config, REFLECTORS_M[:2], driven, setting, 0.04).poses
    both = _known(quick_config, joined(still, moving))
    assert both.stored.parameters.motion_count == 1
    S, alone = (machine_covariance(one.stored, one.model, one.path) for one in (both, known))
    machines = possible_machines(both.stored, both.config.machine, both.path, 3.0)
    np.testing.assert_allclose(machines.factor @ machines.factor.T, S, atol=1e-9 * S.max())
    deviations, before = (np.sqrt(np.diagonal(one)) for one in (S, alone))
    assert np.median(deviations / np.maximum(before, 1e-12)) < 1.0


def test_an_uncalibrated_machine_is_refused(known: Known, quick_config: Config) -> None:
    """The configuration that calibration began with is another machine."""
    with pytest.raises(UsageError, match=r"not the calibrated one: .* parameters differ"):
        require_calibrated(known.stored, quick_config.machine)


def _shorter(data: dict[str, Any]) -> None:
    data["covariance"].pop()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data.pop("covariance"), "covariance: Field required"),
        (_shorter, "other parameters than a machine with 2 reflectors"),
        (lambda data: data["parameters"].reverse(), "other parameters than a machine with 2 reflectors"),
        (lambda data: data.update(accepted=False), "was not accepted"),
        (lambda data: data["covariance"][0].__setitem__(1, 1.0), "not symmetric"),
        (lambda data: data["covariance"][0].__setitem__(0, "a"), "covariance.0.0: Input should be a valid number"),
        (lambda data: data["setting"].update(reflectors_m=[]), "setting.reflectors_m"),
    ],
)
def test_files_that_are_no_calibration_are_refused(
    known: Known, change: Callable[[dict[str, Any]], object], said: str
) -> None:
    """With what is wrong and what to give."""
    data = json.loads(json.dumps(known.data))
    change(data)
    with pytest.raises(UsageError, match="What to change") as caught:
        parse_calibration(json_bytes(data), "real.json")
    assert said in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"\xff", b'{"accepted": NaN}'])
def test_damaged_files_are_refused(content: bytes) -> None:
    """Without a traceback."""
    with pytest.raises(UsageError, match="is not the file of a calibration"):
        parse_calibration(content, "real.json")

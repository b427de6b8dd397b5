"""A calibrated machine in the user's configuration."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.calibrate import calibrated_yaml
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.model.parameters import DIRECTIONS
from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.errors import UsageError
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import build_machine, cart_joints
from pipeline.yaml_text import parse_yaml
from tests.calibrate.conftest import REFLECTORS_M
from tests.conftest import CONFIGS


def moved(config: Config, seed: int, std_m: float, *, parallel: bool = True) -> Model:
    """Draw a machine, by default one whose rails are as parallel as before."""
    model = configured_model(config.machine, REFLECTORS_M)
    theta = np.random.default_rng(seed).normal(0.0, std_m, model.parameters.count)
    if parallel:
        model.parameters.of(DIRECTIONS, theta)[:] = 0.0
    return model.moved(theta)


@pytest.mark.parametrize("name", ["agder", "quick", "tiny", "fast", "paper"])
def test_every_configuration_can_be_calibrated(name: str):
    """The new text reads as the calibrated machine, to a nanometre, and all that is not of the machine is the same."""
    file = CONFIGS / f"{name}.yaml"
    config = load_config(file)
    model = moved(config, 1, 2e-4)
    text = calibrated_yaml(file.read_text(), config, model, "Calibrated.")
    new = parse_config(parse_yaml(text), default_name=name)
    np.testing.assert_allclose(configured_model(new.machine, model.reflectors_m).values(), model.values(), atol=1e-9)
    assert new.model_copy(update={"machine": config.machine}) == config
    assert text.splitlines()[0] == "# Calibrated."
    comments = [line.split("#", 1)[1] for line in file.read_text().splitlines() if "#" in line]
    assert [line.split("#", 1)[1] for line in text.splitlines()[1:] if "#" in line] == comments


def test_what_does_not_change_is_not_written(quick_config: Config):
    """The machine as configured leaves the text as it is, but for the heading."""
    text = (CONFIGS / "quick.yaml").read_text()
    same = configured_model(quick_config.machine, REFLECTORS_M)
    assert calibrated_yaml(text, quick_config, same, "Same.") == f"# Same.\n{text}"


def test_joints_that_were_one_stay_one(quick_config: Config):
    """Where 3a and 3c are found farther apart than joints may be that are one, this distance is written, too."""
    text = (CONFIGS / "quick.yaml").read_text()
    far = moved(quick_config, 2, 2e-3)
    apart = float(np.linalg.norm(far.cart_offsets_m[3] - far.cart_offsets_m[5]))
    assert apart > 0.002
    new = parse_config(parse_yaml(calibrated_yaml(text, quick_config, far, "Far.")))
    assert apart <= new.machine.clearance.shared_joint_m < apart + 0.0011


@pytest.mark.parametrize("slope", [1e-4, 3e-3])
def test_rails_that_are_not_parallel_are_written(quick_config: Config, slope: float):
    """They are read as the same lines with the same encoders, again and again; slopes may become zero, too."""
    text, found = (CONFIGS / "quick.yaml").read_text(), moved(quick_config, 4, slope / 3.0, parallel=False)
    first = calibrated_yaml(text, quick_config, found, "First.")
    new = parse_config(parse_yaml(first), default_name="quick")
    read = configured_model(new.machine, found.reflectors_m)
    np.testing.assert_allclose(read.values(), found.values(), atol=1.1e-9)
    q = np.random.default_rng(1).uniform(0.9, 1.5, (20, 5))
    machine, units = build_machine(new.machine), controller_units(new.machine)
    joints = cart_joints(machine, units.to_geometry(q)[:, :3])
    np.testing.assert_allclose(joints, found.cart_joints(q), atol=5e-9)
    straight = read.moved(-_only_directions(read))
    level = parse_config(parse_yaml(calibrated_yaml(first, new, straight, "Second.")), default_name="quick")
    assert build_machine(level.machine).has_parallel_rails
    np.testing.assert_allclose(
        configured_model(level.machine, found.reflectors_m).values(), straight.values(), atol=1.1e-9
    )


def _only_directions(model: Model) -> np.ndarray:
    theta = np.zeros(model.parameters.count)
    model.parameters.of(DIRECTIONS, theta)[:] = model.directions_rad.ravel()
    return theta


def test_rails_that_are_far_off_are_refused(quick_config: Config):
    """Nothing is planned for rails that are as far off as that: they are to be aligned."""
    model = configured_model(quick_config.machine, REFLECTORS_M)
    steep = model.moved(np.full(model.parameters.count, 0.006) * (model.parameters.is_fitted(("directions",))))
    with pytest.raises(UsageError, match=r"6\.00 mm per metre off X.*\n.*align"):
        calibrated_yaml((CONFIGS / "quick.yaml").read_text(), quick_config, steep, "No.")


def test_anchors_of_parts_that_differ_are_refused(tmp_path: Path, quick_config: Config):
    """A text that says the same of two links cannot say what differs: refused with a way out."""
    text = (CONFIGS / "quick.yaml").read_text()
    assert "cart_offset_m: [0.0, 0.28, 0.0]" in text
    text = text.replace("cart_offset_m: [0.0, 0.28, 0.0]", "cart_offset_m: &one [0.0, 0.28, 0.0]", 1)
    text = text.replace("cart_offset_m: [0.0, 0.28, 0.0]", "cart_offset_m: *one", 1)
    file = tmp_path / "anchors.yaml"
    file.write_text(text)
    with pytest.raises(UsageError, match=r"in several places.*\n.*--yaml"):
        calibrated_yaml(text, load_config(file), moved(quick_config, 3, 2e-4), "No.")

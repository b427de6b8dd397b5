"""A calibrated machine in the user's configuration."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.calibrate import calibrated_yaml
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.model.parameters import DIRECTIONS
from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.errors import UsageError
from pipeline.yaml_text import parse_yaml
from tests.calibrate.conftest import REFLECTORS_M, Seen
from tests.conftest import CONFIGS


def moved(config: Config, seed: int, std_m: float) -> Model:
    """Draw a machine with parallel rails."""
    model = configured_model(config.machine, REFLECTORS_M)
    theta = np.random.default_rng(seed).normal(0.0, std_m, model.parameters.count)
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


def test_rails_that_are_not_parallel_are_refused(see: Callable[..., Seen], quick_config: Config):
    """A configuration has parallel rails, and is not written with others left out silently."""
    truth = see(2, poses=5, direction_std_rad=1e-4).simulated.truth
    with pytest.raises(UsageError, match="rails that are not parallel"):
        calibrated_yaml((CONFIGS / "quick.yaml").read_text(), quick_config, truth, "No.")


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

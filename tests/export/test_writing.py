"""What is written for a controller is in its units, and what shows the machine is not."""

import numpy as np
import pytest

from pipeline.export import ExportOptions, ExportRequest, export_files, read_motion
from pipeline.export.formats import Format
from pipeline.machine import Machine
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from pipeline.machine.geometry import ACTUATORS

_UNITS = ControllerUnits(
    middles_m=np.array([1.0, 1.0, 1.0, 1.1, 1.25]),
    zeros_m=np.array([0.0, 4e-4, 0.0, -3e-4, 2e-4]),
    scales=np.array([1.0, 1.0, 0.9998, 1.0002, 1.0]),
)


@pytest.mark.parametrize("kind", [kind for kind in Format if kind.reader])
def test_controllers_are_given_their_own_positions(kind: Format, make_samples, machine: Machine):
    """What a controller reads, converted back, is the planned motion; a simulator reads the planned motion itself."""
    if kind is Format.MCAP:
        pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
    options = ExportOptions(tolerance_m=0.0) if kind is Format.CAM else ExportOptions()
    samples, limits = make_samples(0.01), np.array([2.0, 2.0, 2.0, 0.5, 0.5])
    request = ExportRequest(samples, limits, ACTUATORS, options, machine, units=_UNITS)
    content = export_files(kind, request)[""]
    motion = read_motion(kind, content if kind is Format.MCAP else content.decode())
    q = motion.q_m if kind is Format.MJCF else _UNITS.to_geometry(motion.q_m)
    np.testing.assert_allclose(q, samples.q_m, rtol=0.0, atol=1e-8)
    if motion.qd_mps is not None and kind is not Format.MJCF:
        np.testing.assert_allclose(motion.qd_mps * _UNITS.scales, samples.qd_mps, rtol=0.0, atol=1e-6)


def test_states_of_a_bag_are_those_of_the_model(make_samples, machine: Machine):
    """Joint states move the model of the machine: they are not in the units of the controller."""
    decoders = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
    import io

    from mcap.reader import make_reader

    samples, limits = make_samples(0.01), np.array([2.0, 2.0, 2.0, 0.5, 0.5])
    content = export_files(Format.MCAP, ExportRequest(samples, limits, ACTUATORS, machine=machine, units=_UNITS))[""]
    reader = make_reader(io.BytesIO(content), decoder_factories=[decoders.DecoderFactory()])
    states = [message.position[:5] for *_, message in reader.iter_decoded_messages(topics=["/joint_states"])]
    np.testing.assert_array_equal(states, samples.q_m)

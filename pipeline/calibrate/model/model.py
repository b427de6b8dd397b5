"""A machine with reflectors as a tracker sees it: all numbers that a calibration may change."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.calibrate.model import parameters as kinds
from pipeline.calibrate.model.parameters import FIXED, Parameters
from pipeline.calibrate.model.rails import Rails
from pipeline.config import MachineConfig
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, build_machine


@dataclass(frozen=True, eq=False)
class Model:
    """A machine, its encoders, reflectors on its platform, and the frame of the tracker that sees them.

    A point P of the machine is at rotation P + translation_m in the frame of the tracker.

    Attributes
    ----------
    platform_points_m, cart_offsets_m : (6, 3)
        Joints of each link, in the platform frame and from the cart's origin.
    rails_m : (3, 2)
        y and z of each rail at the middle of its travel.
    directions_rad : (3, 2)
        Slopes of each rail, along Y and Z per metre along X.
    lengths_m : (6,)
        Link lengths; NaN for the telescopes.
    middles_m, zeros_m, scales : (5,)
        What encoders show, see `ControllerUnits`.
    reflectors_m : (n, 3)
        Reflectors in the platform frame.
    rotation : (3, 3)
        Orientation of the machine's frame in the tracker's.
    translation_m : (3,)
        Origin of the machine's frame in the tracker's.
    clocks_s : (motions,)
        By how much the clock of the tracker is late, for every motion that was measured.
    """

    platform_points_m: FloatArray
    cart_offsets_m: FloatArray
    rails_m: FloatArray
    directions_rad: FloatArray
    lengths_m: FloatArray
    middles_m: FloatArray
    zeros_m: FloatArray
    scales: FloatArray
    reflectors_m: FloatArray
    rotation: FloatArray
    translation_m: FloatArray
    clocks_s: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def parameters(self) -> Parameters:
        """The parameters that change it."""
        return Parameters(len(self.reflectors_m), len(self.clocks_s))

    def moved(self, theta: FloatArray) -> "Model":
        """Add deviations (count,) of all parameters."""
        of = self.parameters.of
        lengths = self.lengths_m.copy()
        lengths[FIXED] += of(kinds.LENGTHS, theta)
        turned, shifted = np.split(of(kinds.TRACKER, theta), 2)
        return replace(
            self,
            platform_points_m=self.platform_points_m + of(kinds.PLATFORM, theta).reshape(6, 3),
            cart_offsets_m=self.cart_offsets_m + of(kinds.OFFSETS, theta).reshape(6, 3),
            rails_m=self.rails_m + of(kinds.RAILS, theta).reshape(3, 2),
            directions_rad=self.directions_rad + of(kinds.DIRECTIONS, theta).reshape(3, 2),
            lengths_m=lengths,
            zeros_m=self.zeros_m + of(kinds.ZEROS, theta),
            scales=self.scales + of(kinds.SCALES, theta),
            reflectors_m=self.reflectors_m + of(kinds.REFLECTORS, theta).reshape(-1, 3),
            clocks_s=self.clocks_s + of(kinds.CLOCKS, theta),
            rotation=Rotation.from_rotvec(turned).as_matrix() @ self.rotation,
            translation_m=self.translation_m + shifted,
        )

    def with_frame(self, rotation: FloatArray, translation_m: FloatArray) -> "Model":
        """Give the same machine seen from another frame."""
        return replace(self, rotation=rotation, translation_m=translation_m)

    def with_clocks(self, clocks_s: FloatArray) -> "Model":
        """Give the same machine, seen by trackers whose clocks are late by (motions,)."""
        return replace(self, clocks_s=clocks_s)

    def actuators(self, q_m: FloatArray) -> FloatArray:
        """Convert what encoders show (n, 5) to cart positions and telescope lengths (n, 5)."""
        return np.asarray(self.middles_m + self.zeros_m + self.scales * (q_m - self.middles_m))

    def to_encoders(self, actuators_m: FloatArray) -> FloatArray:
        """Convert cart positions and telescope lengths (n, 5) to what encoders show (n, 5)."""
        return np.asarray(self.middles_m + (actuators_m - self.middles_m - self.zeros_m) / self.scales)

    def values(self) -> FloatArray:
        """Give what all parameters deviate from: the machine's own numbers, zero for the tracker's frame. (count,)."""
        return np.concatenate(
            [
                *(self.platform_points_m.ravel(), self.cart_offsets_m.ravel(), self.rails_m.ravel()),
                *(self.lengths_m[FIXED], self.zeros_m, self.scales, self.directions_rad.ravel()),
                *(self.reflectors_m.ravel(), self.clocks_s, np.zeros(len(kinds.TRACKER.names))),
            ]
        )

    def cart_joints(self, q_m: FloatArray) -> FloatArray:
        """C_l = (c_k + b_x, rail_y + b_y + slope_y (c_k - middle), likewise z) for encoders (n, 5). Shape (n, 6, 3)."""
        carts = self.actuators(q_m)[:, :3]
        along = np.concatenate([np.zeros((3, 1)), self.rails_m], axis=1)
        direction = np.concatenate([np.ones((3, 1)), self.directions_rad], axis=1)
        along[:, 0] = self.middles_m[:3]
        joints = along + direction * (carts - self.middles_m[:3])[..., None]
        return np.asarray(joints[:, ARM_OF_LINK] + self.cart_offsets_m)

    def link_lengths(self, q_m: FloatArray) -> FloatArray:
        """Lengths of the six links for encoders (n, 5). Shape (n, 6)."""
        lengths = np.broadcast_to(self.lengths_m, (len(q_m), 6)).copy()
        lengths[:, TELESCOPES] = self.actuators(q_m)[:, 3:]
        return lengths


def configured_model(config: MachineConfig, reflectors_m: FloatArray) -> Model:
    """Take the machine as configured, with reflectors (n, 3), in a tracker's frame that is its own."""
    machine, units = build_machine(config), controller_units(config)
    slopes = np.array([rail.slopes for rail in config.rails])
    rails = Rails(machine.rails_m, slopes, units.middles_m[:3], units.zeros_m[:3], units.scales[:3]).at_middles()
    return Model(
        platform_points_m=machine.platform_points_m,
        cart_offsets_m=machine.cart_offsets_m,
        rails_m=rails.places_m,
        directions_rad=rails.slopes,
        lengths_m=machine.lengths_m,
        middles_m=units.middles_m,
        zeros_m=np.append(rails.zeros_m, units.zeros_m[3:]),
        scales=np.append(rails.scales, units.scales[3:]),
        reflectors_m=np.asarray(reflectors_m, dtype=float),
        rotation=np.eye(3),
        translation_m=np.zeros(3),
    )

"""The machine that is really there: the model, or one whose geometry, masses or load are a little different."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.arguments import require_number, require_whole
from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine.geometry import Machine
from pipeline.machine.masses import Masses
from pipeline.measured.perturbed import generators, perturbed


@dataclass(frozen=True)
class Deviations:
    """How the real machine differs from its model.

    Attributes
    ----------
    geometry_std_m : float
        Standard deviation of joints, rails, fixed lengths and zeros of telescopes, drawn once.
    seed : int
        The same seed draws the same machine.
    mass_error : float
        Part by which every mass and inertia but the load is larger (0.05) or smaller (-0.05).
    load_kg : float
        A load at the TCP that the model does not know of.

    Raises
    ------
    ArgumentError
        When a figure is not finite, or none that a machine can have.
    """

    geometry_std_m: float = 0.0
    seed: int = 0
    mass_error: float = 0.0
    load_kg: float = 0.0

    def __post_init__(self) -> None:
        require_number("geometry_std_m", self.geometry_std_m, least=0.0)
        require_whole("seed", self.seed, 0, 2**53)
        require_number("mass_error", self.mass_error, above=-1.0)
        require_number("load_kg", self.load_kg, least=0.0)


@dataclass(frozen=True, eq=False)
class Plant:
    """The real machine: its geometry and masses, and by how much its telescopes are longer than encoders say (2,)."""

    machine: Machine
    zeros_m: FloatArray

    @property
    def offsets_m(self) -> FloatArray:
        """By how much the actuators are farther than their encoders say. Shape (5,)."""
        return np.concatenate([np.zeros(3), self.zeros_m])


def build_plant(machine: Machine, deviations: Deviations) -> Plant:
    """Draw the real machine.

    Raises
    ------
    UsageError
        For a machine without masses: nothing moves it.
    """
    require_masses(machine)
    # The draw is the one of a simulated measurement with the same seed.
    geometry, _ = generators(deviations.seed)
    real, zeros_m = perturbed(machine, deviations.geometry_std_m, geometry)
    return Plant(replace(real, masses=_heavier(machine.known_masses, deviations)), zeros_m)


def _heavier(masses: Masses, deviations: Deviations) -> Masses:
    factor = 1.0 + deviations.mass_error
    return replace(
        masses,
        cart_kg=factor * masses.cart_kg,
        link_kg=factor * masses.link_kg,
        platform_kg=factor * masses.platform_kg,
        platform_inertia_kgm2=factor * masses.platform_inertia_kgm2,
        load_kg=masses.load_kg + deviations.load_kg,
    )


def require_masses(machine: Machine) -> Machine:
    """Require a machine with masses.

    Raises
    ------
    UsageError
        When it has none: nothing moves it.
    """
    if machine.masses is None:
        raise UsageError(
            "the machine has no masses, so that no forces move it.\n"
            "  What to change: give machine.dynamics in the configuration, and run the pipeline again."
        )
    return machine

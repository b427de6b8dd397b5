"""The kinds of limit, and the limits that each use of the machine has to keep."""

from typing import Protocol

from pipeline.config import Config
from pipeline.limits import (
    actuators,
    avoid,
    gravity_stiffness,
    holding_force,
    joint_cone,
    kappa,
    link_link,
    link_rail,
    tilt,
)
from pipeline.limits.bodies import body_distance, obstacle_distance
from pipeline.limits.interface.limit import ErrorProvenLimit, Limit, NodeLimit, ProvenLimit
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey
from pipeline.limits.interface.relaxation import Relaxation
from pipeline.machine.geometry import Machine


class LimitKind(Protocol):
    """What the module of a kind of limit offers; a kind without a limit for some use returns an empty list."""

    MEASURES: tuple[Measure, ...]
    CERTIFICATE: CertificateEntry

    def for_poses(self, machine: Machine, kappa_max: float) -> list[Limit]:
        """Return the limits of poses by themselves, without a given x."""

    def for_moves(self, config: Config, machine: Machine) -> list[Limit]:
        """Return the limits all along a move between two regions that keep those of poses."""

    def for_path(self, config: Config, machine: Machine) -> list[Limit]:
        """Return the limits of a path."""

    def relaxations(self, config: Config, machine: Machine) -> list[Relaxation]:
        """Return milder values of the limit, for finding out what prevents a route."""


KINDS: tuple[LimitKind, ...] = (
    kappa,
    link_link,
    link_rail,
    body_distance,
    obstacle_distance,
    holding_force,
    gravity_stiffness,
    tilt,
    joint_cone,
    avoid,
    actuators,
)
"""All kinds, in the order in which messages name them."""
BOUND_TO_X: tuple[LimitKind, ...] = (obstacle_distance, avoid)
"""Those that x decides about: they cut the windows of regions."""


def pose_limits(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return what makes a pose usable at some x, cheap limits first: each is checked on what the last one left."""
    limits = [limit for kind in KINDS for limit in kind.for_poses(machine, kappa_max)]
    return sorted(limits, key=lambda limit: limit.cost)


def task_pose_limits(config: Config, machine: Machine) -> list[Limit]:
    """Return what a given pose of the task has to keep, with an x of its own: all that a pose alone can keep.

    Kinds without a limit of poses by themselves, such as tilt and boxes to avoid, have that of a path.
    """
    found = [kind.for_poses(machine, config.route.kappa_max) or kind.for_path(config, machine) for kind in KINDS]
    return [actuators.cart_travel(machine), *(limit for limits in found for limit in limits)]


def unlimited_measures(config: Config, machine: Machine) -> tuple[Measure, ...]:
    """Return what is measured of kinds for which the configuration has no limit; some are NaN or infinite then."""
    without = [
        kind
        for kind in KINDS
        if not kind.for_poses(machine, config.route.kappa_max) and not kind.for_path(config, machine)
    ]
    return tuple(measure for kind in without for measure in kind.MEASURES if measure.applies(machine))


def move_limits(config: Config, machine: Machine, *, given_x: bool = True) -> list[Limit]:
    """Return what has to hold all along a move between two regions; without a given x what does not depend on it."""
    kinds = KINDS if given_x else [kind for kind in KINDS if kind not in BOUND_TO_X]
    return [limit for kind in kinds for limit in kind.for_moves(config, machine)]


def path_limits(config: Config, machine: Machine) -> list[Limit]:
    """Return what has to hold all along a path."""
    return [limit for kind in KINDS for limit in kind.for_path(config, machine)]


def proven_limits(config: Config, machine: Machine) -> list[ProvenLimit]:
    """Return the limits of a path that a certificate bounds."""
    return [limit for limit in path_limits(config, machine) if isinstance(limit, ProvenLimit)]


def error_proven_limits(config: Config, machine: Machine) -> list[ErrorProvenLimit]:
    """Return the limits of a path that are bounded for errors of the actuators, too: kappa and distances of axes."""
    return [limit for limit in path_limits(config, machine) if isinstance(limit, ErrorProvenLimit)]


def certificate_keys() -> tuple[CertificateKey, ...]:
    """Return the keys of all bounds that a certificate states, each once."""
    return tuple(dict.fromkeys(key for kind in KINDS for key in kind.CERTIFICATE.keys))


def node_limits(config: Config, machine: Machine) -> list[NodeLimit]:
    """Return the limits of a path that both programs of stage two keep at their nodes."""
    return [limit for limit in path_limits(config, machine) if isinstance(limit, NodeLimit)]


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return the limits that could give, leaving out those that refuse nothing."""
    found = [relaxation for kind in KINDS for relaxation in kind.relaxations(config, machine)]
    return [relaxation for relaxation in found if len(relaxation.levels) > 1]


def measures() -> tuple[Measure, ...]:
    """Return what is measured of a path in the units of its limits."""
    return tuple(measure for kind in KINDS for measure in kind.MEASURES)

"""Drives and their controllers as arrays, in the order of the actuators."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config.drives import CartDriveConfig, DrivesConfig
from pipeline.config.machine.limits import push_and_pull
from pipeline.machine.geometry import Machine

_ASSUMED_DRY_FRICTION_N = np.array([20.0, 20.0, 20.0, 40.0, 40.0])
"""Where neither the drives nor the machine's dynamics say anything."""


@dataclass(frozen=True, eq=False)
class Drives:
    """The five drives c1, c2, c3, l2b, l3b, an array (5,) per figure.

    Attributes
    ----------
    position_gain_per_s, velocity_gain_nspm : (5,)
        kp and kv of the cascade F = kv (kp e + ...).
    integral_gain_npm : (5,)
        kv / Tn; 0 without an integral.
    velocity_forward, force_forward, friction_forward : (5,)
        Parts of velocity, force and friction that are fed forward, 0 to 1.
    dry_friction_n, viscous_friction_nspm, moving_mass_kg : (5,)
        What the drives' own motion takes.
    saturation_n : (2, 5)
        Largest push and pull; infinite where there is none.
    encoder_step_m : (5,)
        Resolution of the measured position; 0: exact.
    force_lag_s, delay_s : (5,)
        Time constant from commanded to real force, and time from measuring to commanding it.
    trip_m : (5,)
        Following error at which a drive switches off.
    """

    position_gain_per_s: FloatArray
    velocity_gain_nspm: FloatArray
    integral_gain_npm: FloatArray
    velocity_forward: FloatArray
    force_forward: FloatArray
    friction_forward: FloatArray
    dry_friction_n: FloatArray
    viscous_friction_nspm: FloatArray
    moving_mass_kg: FloatArray
    saturation_n: FloatArray
    encoder_step_m: FloatArray
    force_lag_s: FloatArray
    delay_s: FloatArray
    trip_m: FloatArray


def build_drives(config: DrivesConfig, machine: Machine) -> Drives:
    """Turn the configuration of the drives into arrays.

    Dry friction that is not given is the machine's, or assumed where that is zero; the saturation the machine's limit
    of force.
    """
    drives = config.of_actuators()

    def each(name: str) -> FloatArray:
        return np.array([float(getattr(drive, name)) for drive in drives])

    def forward(name: str) -> FloatArray:
        return np.array([float(getattr(drive.feed_forward, name)) for drive in drives])

    return Drives(
        position_gain_per_s=each("position_gain_per_s"),
        velocity_gain_nspm=each("velocity_gain_nspm"),
        integral_gain_npm=np.array([_integral_gain(drive) for drive in drives]),
        velocity_forward=forward("velocity"),
        force_forward=forward("force"),
        friction_forward=forward("friction"),
        dry_friction_n=_dry_friction(drives, machine),
        viscous_friction_nspm=each("viscous_friction_nspm"),
        moving_mass_kg=each("moving_mass_kg"),
        saturation_n=_saturation(drives, machine),
        encoder_step_m=each("encoder_step_m"),
        force_lag_s=each("force_lag_s"),
        delay_s=each("delay_s"),
        trip_m=each("following_error_trip_m"),
    )


def ideal_drives(drives: Drives) -> Drives:
    """Give the same controllers with drives that have no mass, friction, lag, delay or steps of encoders."""
    none = np.zeros(5)
    return Drives(
        **{
            **vars(drives),
            **dict.fromkeys(("dry_friction_n", "viscous_friction_nspm", "moving_mass_kg"), none),
            **dict.fromkeys(("encoder_step_m", "force_lag_s", "delay_s"), none),
            **dict.fromkeys(("velocity_forward", "force_forward"), np.ones(5)),
        }
    )


def _integral_gain(drive: CartDriveConfig) -> float:
    return 0.0 if drive.integral_time_s is None else drive.velocity_gain_nspm / drive.integral_time_s


def _dry_friction(drives: tuple[CartDriveConfig, ...], machine: Machine) -> FloatArray:
    planned = np.zeros(5) if machine.masses is None else machine.masses.friction_n
    otherwise = np.where(planned > 0.0, planned, _ASSUMED_DRY_FRICTION_N)
    given = [drive.dry_friction_n for drive in drives]
    return np.array([rest if own is None else own for own, rest in zip(given, otherwise, strict=True)])


def _saturation(drives: tuple[CartDriveConfig, ...], machine: Machine) -> FloatArray:
    given = np.array([push_and_pull(drive.saturation_n) for drive in drives]).T
    return np.where(np.isfinite(given), given, machine.force_limits_n[:, :5])

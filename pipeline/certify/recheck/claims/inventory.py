"""The chains of a certificate: that of the configured machine, and one per stated tolerance."""

from collections.abc import Callable, Iterator

from pipeline.certify.following import following_weights
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.statement import StatedMachines, StatedTolerance, Statement
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_actuators, of_everything, of_lengths
from pipeline.machine.geometry import ACTUATORS, Machine

NOMINAL = "the first chain is of the configured machine"
LENGTHS = "the tolerance of link lengths has its chain"
EVERYTHING = "the tolerance of coordinates has its chain"
FOLLOWING = "every tolerance of following errors has its chain"
MACHINES = "the machines of a calibration have their chain"
PROFILES = "profiles of following errors are of the stated kind"
OFF_X = "; rails are off X"
CLAIMS: tuple[str, ...] = (NOMINAL, LENGTHS, EVERYTHING, FOLLOWING, PROFILES, MACHINES)


def inventory_claims(machine: Machine, stated: Statement) -> Iterator[Claim]:
    """Verify that the chains are those that the certificate speaks of, and no others."""
    first, rest = stated.chains[:1], stated.chains[1:]
    boxes = len(first[0].boxes) if first else 0
    configured = [chain.uncertainty for chain in first] == [CERTAIN]
    yield Claim(NOMINAL, configured and boxes == stated.boxes, f"{boxes} boxes; stated {stated.boxes}")
    possible, rest = [one for one in rest if _of_machines(one)], tuple(one for one in rest if not _of_machines(one))
    following, rest = [one for one in rest if _of_errors(one)], tuple(one for one in rest if not _of_errors(one))
    coordinates = [chain for chain in rest if chain.uncertainty.coordinate_m > 0.0]
    lengths = [chain for chain in rest if chain.uncertainty.coordinate_m == 0.0]
    yield _tolerance_claim(LENGTHS, stated.link_length, lengths, of_lengths)
    yield _tolerance_claim(EVERYTHING, stated.coordinates, coordinates, of_everything)
    yield _following_claim(machine, stated, [chain for chain in following if chain.profile_m is None])
    yield _profile_claim([chain for chain in following if chain.profile_m is not None])
    yield _machines_claim(machine, stated.machines, possible)


def _of_errors(chain: ProvenChain) -> bool:
    return any(chain.uncertainty.actuator_m) or chain.profile_m is not None or chain.within_limits


def _of_machines(chain: ProvenChain) -> bool:
    return chain.uncertainty.ellipsoid is not None


def _machines_claim(machine: Machine, stated: StatedMachines | None, chains: list[ProvenChain]) -> Claim:
    """Verify that what is stated of the machines of a calibration has exactly one chain, of its size and kind.

    Nothing is proven of machines whose rails are off X.
    """
    found = [
        (one.sigma, one.factor.shape[1], len(chain.boxes), chain.within_limits, chain.profile_m)
        for chain in chains
        if (one := chain.uncertainty.ellipsoid) is not None
    ]
    wanted = [] if stated is None else [(stated.sigma, stated.dimensions, stated.boxes, stated.within_limits, None)]
    said = "none stated" if stated is None else f"stated {stated.sigma:g} deviations in {stated.boxes} boxes"
    along_x = machine.has_parallel_rails or not chains
    return Claim(MACHINES, found == wanted and along_x, f"{len(chains)} chains; {said}{'' if along_x else OFF_X}")


def _following_claim(machine: Machine, stated: Statement, chains: list[ProvenChain]) -> Claim:
    """Verify that every tolerance that is not zero has exactly one chain, of its errors and size, and no other is."""
    weights, following = following_weights(machine), stated.following
    wanted = [
        (of_actuators(weights[name])(one.eps_m), one.boxes, within)
        for within, found in ((True, following.within_limits), (False, following.on_branch))
        for name, one in found.items()
        if name in weights and one.eps_m > 0.0
    ]
    tolerances = {
        **{f"{name} within limits": one for name, one in following.within_limits.items()},
        **following.on_branch,
    }
    known = {*following.within_limits, *following.on_branch} <= weights.keys()
    if (beside := following.calibrated) is not None:
        one = tolerances["beside calibration errors"] = beside.tolerance
        errors = Uncertainty(beside.length_m, beside.coordinate_m, (one.eps_m,) * len(ACTUATORS))
        wanted += [(errors, one.boxes, False)] if one.eps_m > 0.0 else []
    proven = [(chain.uncertainty, len(chain.boxes), chain.within_limits) for chain in chains]
    none = all(one.boxes == 0 for one in tolerances.values() if one.eps_m == 0.0)
    eps = ", ".join(f"{name} {1e3 * one.eps_m:.4g} mm" for name, one in tolerances.items())
    return Claim(FOLLOWING, known and none and proven == wanted, f"{len(chains)} chains; stated {eps or 'none'}")


def _profile_claim(chains: list[ProvenChain]) -> Claim:
    """Verify that there is at most one profile of each claim, and that each states the least of its errors."""
    within = [chain.within_limits for chain in chains]
    least = all(chain.uncertainty == _least_errors(chain) for chain in chains)
    return Claim(PROFILES, least and len(set(within)) == len(within), f"{len(chains)} chains")


def _least_errors(chain: ProvenChain) -> Uncertainty:
    return Uncertainty(actuator_m=(min(chain.profile_m or (0.0,)),) * len(ACTUATORS))


def stated_reserves(stated: Statement) -> list[tuple[float, float] | None]:
    """Give what is stated of the tilts' reserves, by chain: of those within limits, in order, that are no profiles."""
    reserves = iter([one.tilt_reserve_deg for one in stated.following.within_limits.values() if one.eps_m > 0.0])
    return [
        next(reserves, None) if chain.within_limits and chain.profile_m is None and not _of_machines(chain) else None
        for chain in stated.chains
    ]


def _tolerance_claim(
    what: str, stated: StatedTolerance | None, chains: list[ProvenChain], kind: Callable[[float], Uncertainty]
) -> Claim:
    """Verify that a tolerance has exactly one chain of its kind, and none if it is zero or not stated."""
    if stated is None:
        return Claim(what, not chains, f"none stated; {len(chains)} chains")
    proven = [(chain.uncertainty, len(chain.boxes)) for chain in chains]
    if stated.eps_m > 0.0:
        kept = proven == [(kind(stated.eps_m), stated.boxes)]
    else:
        kept = stated.eps_m == 0.0 and stated.boxes == 0 and not chains
    eps = ", ".join(f"{1e3 * max(u.length_m, u.coordinate_m):.6g} mm in {n} boxes" for u, n in proven) or "no chain"
    return Claim(what, kept, f"{eps}; stated {1e3 * stated.eps_m:.6g} mm in {stated.boxes}")

"""The chains of a certificate: that of the configured machine, and one per stated tolerance."""

from collections.abc import Callable, Iterator

from pipeline.certify.following import following_weights
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.statement import StatedTolerance, Statement
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty, of_actuators, of_everything, of_lengths
from pipeline.machine.geometry import Machine

NOMINAL = "the first chain is of the configured machine"
LENGTHS = "the tolerance of link lengths has its chain"
EVERYTHING = "the tolerance of coordinates has its chain"
FOLLOWING = "every tolerance of following errors has its chain"
CLAIMS: tuple[str, ...] = (NOMINAL, LENGTHS, EVERYTHING, FOLLOWING)


def inventory_claims(machine: Machine, stated: Statement) -> Iterator[Claim]:
    """Verify that the chains are those that the certificate speaks of, and no others."""
    first, rest = stated.chains[:1], stated.chains[1:]
    boxes = len(first[0].boxes) if first else 0
    configured = [chain.uncertainty for chain in first] == [CERTAIN]
    yield Claim(NOMINAL, configured and boxes == stated.boxes, f"{boxes} boxes; stated {stated.boxes}")
    following = [chain for chain in rest if any(chain.uncertainty.actuator_m)]
    rest = tuple(chain for chain in rest if not any(chain.uncertainty.actuator_m))
    coordinates = [chain for chain in rest if chain.uncertainty.coordinate_m > 0.0]
    lengths = [chain for chain in rest if chain.uncertainty.coordinate_m == 0.0]
    yield _tolerance_claim(LENGTHS, stated.link_length, lengths, of_lengths)
    yield _tolerance_claim(EVERYTHING, stated.coordinates, coordinates, of_everything)
    yield _following_claim(machine, stated, following)


def _following_claim(machine: Machine, stated: Statement, chains: list[ProvenChain]) -> Claim:
    """Verify that every tolerance that is not zero has exactly one chain, of its errors and size, and no other is."""
    weights = following_weights(machine)
    wanted = [
        (of_actuators(weights[name])(one.eps_m), one.boxes)
        for name, one in stated.following.items()
        if name in weights and one.eps_m > 0.0
    ]
    proven = [(chain.uncertainty, len(chain.boxes)) for chain in chains]
    known = all(name in weights for name in stated.following)
    none = all(one.boxes == 0 for one in stated.following.values() if one.eps_m == 0.0)
    eps = ", ".join(f"{name} {1e3 * one.eps_m:.4g} mm" for name, one in stated.following.items())
    return Claim(FOLLOWING, known and none and proven == wanted, f"{len(chains)} chains; stated {eps or 'none'}")


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

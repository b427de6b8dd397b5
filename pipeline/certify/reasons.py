"""Why a path is not proven, and what to change."""

from dataclasses import dataclass

REGULARITY = "regularity"
_MORE_NODES = "Raise refine.nodes, and refine again."


@dataclass(frozen=True)
class Reason:
    """Why something could not be proven.

    Attributes
    ----------
    text : str
        What is wrong.
    advice : str
        What to change.
    limit : str
        What is not kept: the quantity that a limit bounds, or that the motion is regular and on one branch.
    """

    text: str
    advice: str = _MORE_NODES
    limit: str = REGULARITY


@dataclass(frozen=True)
class ProofFailure:
    """Where and why a proof ends before the path does."""

    s: float
    reason: Reason


NO_POSE = Reason(
    "the links cannot close",
    "Give the path a wider berth: lower refine.kappa_max, or raise refine.nodes.",
)
NO_INCLUSION = Reason(
    "no box could be proven to hold exactly one pose",
    "The path meets a singularity there, or comes too near one: lower refine.kappa_max, or raise refine.nodes; "
    "certify.least_width may be smaller.",
)
JUMP = Reason(
    "the path jumps from one branch to another",
    "Raise refine.nodes: the path is not one motion.",
)
NOT_VERIFIED = Reason(
    "other arithmetic does not verify the chain",
    "Raise certify.precision_bits, or lower refine.kappa_max.",
)
SPLINES_INCOMPLETE = Reason("the splines do not reach from s = 0 to s = 1")
ACTUATORS_JUMP = Reason("the actuators jump")

"""Why a move is rejected when it is followed continuously."""

from dataclasses import dataclass

from pipeline.limits import Limit


@dataclass(frozen=True, order=True)
class Rejection:
    """A reason: in words, and a configuration key that, raised, admits more moves (empty if there is none)."""

    reason: str
    raise_key: str = ""

    @classmethod
    def of(cls, limit: Limit) -> "Rejection":
        """Name the limit that a move breaks."""
        return cls(limit.wording.rejected_move, limit.wording.raise_key)

    def __str__(self) -> str:
        return self.reason


NO_CLOSURE = Rejection("the closure equations lose their solution")
WRONG_BRANCH = Rejection("it ends on another branch of the forward kinematics")
SIGN_CHANGE = Rejection("det H changes sign")
BRANCH_REJECTIONS = (NO_CLOSURE, WRONG_BRANCH, SIGN_CHANGE)
"""What can be wrong with the line itself, before any limit."""

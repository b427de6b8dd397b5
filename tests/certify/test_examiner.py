"""Limits are bounded one after the other; what is not proven, or not sharp, is a reason to halve the box."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from pipeline.certify.chain import close_chain
from pipeline.certify.examiner import LimitExaminer, build_examiner
from pipeline.certify.problem import build_problem
from pipeline.certify.reasons import Reason
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.limits import CertificateKey, ProvenLimit, ProvenQuantity, Side, proven_limits
from pipeline.limits.interface.limit import Wording
from pipeline.limits.kappa import KappaCap
from pipeline.limits.tilt import TiltLimit
from pipeline.machine import Machine
from pipeline.refine import Path

TIME = CertificateKey("time_s", Side.BOTH)


@dataclass(frozen=True, eq=False)
class LimitOfS(TiltLimit):
    """A made-up limit: s stays below a value."""

    most: float = 1.0

    @property
    def wording(self) -> Wording:
        """Advise something of its own."""
        return replace(super().wording, proof_advice="Stop earlier.")

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """Bound s alone."""
        return (ProvenQuantity(TIME, "time_s", (-np.inf, self.most)),)

    def bound(self, box: ProvenBox) -> np.ndarray:
        """Read s off the box."""
        return np.array([[box.inclusion.box.first, box.inclusion.box.last]])

    def unproven(self, bounds: np.ndarray) -> str:
        """Compare."""
        return f"s is beyond {self.most}" if bounds[0, 1] > self.most else ""


def prove(machine: Machine, path: Path, examiner: LimitExaminer) -> tuple[int, float, Reason | None]:
    """Close a chain; return the number of boxes, where they end, and why."""
    with working_precision(64):
        chain = close_chain(build_problem(machine, path, 1e-3), examiner)
    failure = chain.failure
    return len(chain.bounds), chain.inclusions[-1].box.last, None if failure is None else failure.reason


def test_a_new_limit_is_bounded_without_the_certificate_knowing_it(machine: Machine, line: Path) -> None:
    """The chain ends where its bounds do not keep it, with the advice of the limit."""
    kept = LimitExaminer([LimitOfS(np.ones(2))], np.inf, 1.0)
    broken = LimitExaminer([LimitOfS(np.ones(2), most=0.4)], np.inf, 1.0)
    assert prove(machine, line, kept)[1:] == (1.0, None)
    count, last, reason = prove(machine, line, broken)
    assert count > 0
    assert last == pytest.approx(0.4, abs=2e-3)
    assert reason == Reason("s is beyond 0.4", "Stop earlier.")


def test_boxes_are_halved_until_kappa_is_sharp_but_not_for_ever(wide: Config, machine: Machine, line: Path) -> None:
    """A goal that cannot be reached halves every box down to the width, and refuses none."""
    limits: list[ProvenLimit] = [KappaCap(1e9)]
    boxes = [prove(machine, line, LimitExaminer(limits, goal, 0.02))[0] for goal in (1e9, 0.0)]
    assert boxes[0] < boxes[1]
    assert prove(machine, line, LimitExaminer(limits, 0.0, 0.02))[1:] == (1.0, None)
    narrow = wide.certify.model_copy(update={"least_width": 0.1})
    assert build_examiner(narrow, limits, 10.0).sharp_width == 0.2


def test_the_goal_is_near_the_samples_and_below_the_cap(wide: Config, machine: Machine) -> None:
    """Whichever is smaller."""
    limits = proven_limits(wide, machine)
    goals = [build_examiner(wide.certify, limits, sampled).kappa_goal for sampled in (50.0, 2e9, np.inf)]
    assert goals == [50.0 * (1.0 + wide.certify.kappa_excess), 1e9, 1e9]

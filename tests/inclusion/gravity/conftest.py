"""The path that bounds of gravity are tested along."""

import pytest

from pipeline.machine import Machine
from pipeline.refine.result import Path
from tests.certify.paths import line_path
from tests.inclusion.wide_boxes import heavy
from tests.rails import off_x


@pytest.fixture(
    scope="module",
    params=[(1.0, False), (0.3, False), (0.3, True)],
    ids=["moments in m", "moments per 0.3 m", "rails off X"],
)
def path(machine: Machine, request: pytest.FixtureRequest) -> Path:
    """Take the short regular path, with a load so far from the tool that turning the platform changes the wrench."""
    length_m, is_off = request.param
    return line_path(heavy(off_x(machine) if is_off else machine, length_m))

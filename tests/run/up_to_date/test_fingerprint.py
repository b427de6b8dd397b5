"""Fingerprints: what they depend on."""

from collections.abc import Callable

from pipeline.config import Config
from pipeline.run.stage_specs import SPECS
from pipeline.run.up_to_date.fingerprint import fingerprint
from pipeline.stage import Stage

Change = Callable[..., Config]


def test_fingerprint_depends_on_results(fast_config: Config) -> None:
    """Another result of an earlier stage gives another fingerprint."""
    one, other = ({Stage.REGIONS: name} for name in "ab")
    assert fingerprint(SPECS, Stage.ROUTE, fast_config, one) == fingerprint(SPECS, Stage.ROUTE, fast_config, one)
    assert fingerprint(SPECS, Stage.ROUTE, fast_config, one) != fingerprint(SPECS, Stage.ROUTE, fast_config, other)

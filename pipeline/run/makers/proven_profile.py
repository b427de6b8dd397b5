"""The proven bound of kappa along the path."""

from typing import TYPE_CHECKING

from pipeline.certify.recheck import KappaProfile, kappa_profile
from pipeline.config.choices import Proof

if TYPE_CHECKING:
    from pipeline.run.results import Results


def proven_profile(results: "Results") -> KappaProfile | None:
    """Give the proven bound of kappa, box by box; None if no proof was asked for."""
    if results.config.certify.what == Proof.NOTHING:
        return None
    return kappa_profile(results.machine, results.refinement.path, results.certificate.chains[0])

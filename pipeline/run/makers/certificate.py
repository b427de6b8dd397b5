"""Make the certificate."""

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.artifacts.results.certificate.stored import certificate_files, chains
from pipeline.artifacts.results.pose_error import pose_error_files, uncertainty_of
from pipeline.certify import Certificate, certify_path
from pipeline.certify.following.steps import following_profile
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.pose_error import bound_pose_error
from pipeline.progress import Monitor
from pipeline.run.makers.following import table_of_proof
from pipeline.run.product import Product
from pipeline.summary.certificate import certificate_facts, certificate_section, skipped_certificate
from pipeline.summary.pose_error import pose_error_part

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_certificate(results: "Results", monitor: Monitor) -> Product:
    """Prove that the path is one motion free of singularities and within its limits, if that is asked for."""
    config = results.config_to_prove
    if config.certify.what == Proof.NOTHING:
        return no_certificate()
    began = time.perf_counter()
    path, asked = results.refinement.path, config.certify.pose_error
    certificate = certify_path(config, results.machine, path, monitor)
    product = certificate_product(config, certificate, time.perf_counter() - began)
    files = {**product.files, **table_of_proof(results, following_profile(chains(certificate)))}
    if asked is None:
        return replace(product, files=files)
    found = bound_pose_error(path, uncertainty_of(asked), config.certify.precision_bits, monitor)
    return Product({**files, **pose_error_files(found)}, {**product.section, **pose_error_part(found)})


def certificate_product(config: Config, certificate: Certificate, seconds: float) -> Product:
    """Make the file and the summary of a certificate; what is used of it later is loaded from the file."""
    files = certificate_files(certificate, certificate_facts(config, seconds))
    return Product(files, certificate_section(certificate))


def no_certificate() -> Product:
    """Make the summary of a proof that was not asked for."""
    return Product({}, skipped_certificate())

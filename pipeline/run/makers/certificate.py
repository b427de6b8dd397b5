"""Make the certificate."""

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.artifacts.results.certificate.stored import certificate_files
from pipeline.bound.bound import bound_all_paths
from pipeline.certify import Certificate, certify_path
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.progress import Monitor
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.run.product import Product
from pipeline.summary.certificate import certificate_facts, certificate_section, every_path_section, skipped_certificate

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_certificate(results: "Results", monitor: Monitor) -> Product:
    """Prove that the path is one motion free of singularities and within its limits, if that is asked for."""
    config = results.config_to_prove
    if config.certify.what == Proof.NOTHING:
        return no_certificate()
    began = time.perf_counter()
    certificate = certify_path(config, results.machine, results.refinement.path, monitor)
    product = certificate_product(config, certificate, time.perf_counter() - began)
    if not config.bound.boxes:
        return product
    ends = task_endpoints(config, results.machine)
    found = bound_all_paths(config, results.machine, ends, config.bound.boxes, monitor)
    return replace(product, section={**product.section, **every_path_section(found)})


def certificate_product(config: Config, certificate: Certificate, seconds: float) -> Product:
    """Make the file and the summary of a certificate; what is used of it later is loaded from the file."""
    files = certificate_files(certificate, certificate_facts(config, seconds))
    return Product(files, certificate_section(certificate))


def no_certificate() -> Product:
    """Make the summary of a proof that was not asked for."""
    return Product({}, skipped_certificate())

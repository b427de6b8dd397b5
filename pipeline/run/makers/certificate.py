"""Make the certificate."""

import time
from typing import TYPE_CHECKING

from pipeline.artifacts.results.certificate.stored import certificate_files, chains
from pipeline.artifacts.results.pose_error import pose_error_files, uncertainty_of
from pipeline.bound.bound import bound_all_paths
from pipeline.certify import Certificate, certify_path
from pipeline.certify.following.steps import following_profile
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.pose_error import bound_pose_error
from pipeline.progress import Monitor
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.run.makers.following import table_of_proof
from pipeline.run.product import Product
from pipeline.summary.certificate import certificate_facts, certificate_section, every_path_section, skipped_certificate
from pipeline.summary.pose_error import pose_error_part

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
    more = (
        Product(table_of_proof(results, following_profile(chains(certificate))), {}),
        _proven_pose_error(results, monitor),
        _every_path(results, monitor),
    )
    return Product(
        {name: file for part in (product, *more) for name, file in part.files.items()},
        {key: value for part in (product, *more) for key, value in part.section.items()},
    )


def _proven_pose_error(results: "Results", monitor: Monitor) -> Product:
    """Bound the tool's error, if that is asked for."""
    certify = results.config.certify
    if certify.pose_error is None:
        return Product({}, {})
    path = results.refinement.path
    found = bound_pose_error(path, uncertainty_of(certify.pose_error), certify.precision_bits, monitor)
    return Product(pose_error_files(found), pose_error_part(found))


def _every_path(results: "Results", monitor: Monitor) -> Product:
    """Bound what any path can do, if that is asked for."""
    config, machine = results.config, results.machine
    if not config.bound.boxes:
        return Product({}, {})
    ends = task_endpoints(config, machine)
    return Product({}, every_path_section(bound_all_paths(config, machine, ends, config.bound.boxes, monitor)))


def certificate_product(config: Config, certificate: Certificate, seconds: float) -> Product:
    """Make the file and the summary of a certificate; what is used of it later is loaded from the file."""
    files = certificate_files(certificate, certificate_facts(config, seconds))
    return Product(files, certificate_section(certificate))


def no_certificate() -> Product:
    """Make the summary of a proof that was not asked for."""
    return Product({}, skipped_certificate())

"""The proof: a certificate that the whole continuous path is one motion free of singularities."""

from pipeline.certify.bounds import Bounds, Ranges
from pipeline.certify.certify import certify_path, prove_path
from pipeline.certify.premises import premises_sha256
from pipeline.certify.result import Certificate, ProvenChain, Tolerance, path_sha256
from pipeline.inclusion.uncertainty import Uncertainty

__all__ = [
    "Bounds",
    "Certificate",
    "ProvenChain",
    "Ranges",
    "Tolerance",
    "Uncertainty",
    "certify_path",
    "path_sha256",
    "premises_sha256",
    "prove_path",
]

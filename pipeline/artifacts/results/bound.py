"""The proof of a bound as a file: K, what it was proven for, and the tree of boxes in three bits a node."""

import hashlib
from pathlib import Path

import numpy as np

from pipeline.arrays import IntArray
from pipeline.artifacts.npz import npz_bytes, read_npz, readable
from pipeline.config import Config
from pipeline.errors import UsageError

_VERSION = 1
_BITS = 3


def bound_bytes(config: Config, kappa: float, codes: IntArray) -> bytes:
    """Write a proof; codes (n,) are those of `pipeline.bound.tree`."""
    bits = (np.asarray(codes)[:, None] >> np.arange(_BITS)) & 1
    return npz_bytes(
        {
            "version": _VERSION,
            "premises_sha256": _premises(config),
            "kappa": kappa,
            "nodes": len(codes),
            "codes": np.packbits(bits.astype(np.uint8).ravel()),
        }
    )


def read_bound(path: Path, config: Config) -> tuple[float, IntArray]:
    """Read a proof for a configuration: K and the codes of the tree.

    Raises
    ------
    UsageError
        When the file is damaged, of another kind, or made for another machine or task.
    OSError
        When there is no such file.
    """
    found = read_npz(path)
    with readable(path):
        if int(found["version"]) != _VERSION:
            raise ValueError(f"version {int(found['version'])}")
        premises, kappa, nodes = str(found["premises_sha256"]), float(found["kappa"]), int(found["nodes"])
        packed = found["codes"]
        if packed.dtype != np.uint8 or packed.ndim != 1 or not 0 < nodes <= 8 * len(packed) // _BITS:
            raise ValueError("its tree is no array of bits")
        if not np.isfinite(kappa) or kappa < 1.0:
            raise ValueError(f"kappa is {kappa}")
        bits = np.unpackbits(packed)[: _BITS * nodes].reshape(nodes, _BITS)
    if premises != _premises(config):
        raise UsageError(
            f"{path} was made for another machine or task.\n  What to change: give the configuration it was made for."
        )
    return kappa, np.asarray((bits.astype(np.int64) << np.arange(_BITS)).sum(axis=1))


def _premises(config: Config) -> str:
    """Hash the machine and the task."""
    text = config.machine.model_dump_json() + config.task.model_dump_json()
    return hashlib.sha256(text.encode()).hexdigest()

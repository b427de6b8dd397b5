"""Which program this is: its version, and a hash of the code that shapes results."""

import functools

from pipeline.run.stage_specs import SPECS, code_roots
from pipeline.run.up_to_date.source_code import code_sha256
from pipeline.stage import STAGES
from pipeline.summary.versions import package_version

_DIGITS = 8


@functools.cache
def program_version() -> str:
    """Name the program as `0.1.0 (code 1a2b3c4d)`: results of another name may be others."""
    roots = dict.fromkeys(root for stage in STAGES for root in code_roots(SPECS, stage))
    return f"{package_version()} (code {code_sha256((*roots, 'pipeline.study.worker.task'))[:_DIGITS]})"

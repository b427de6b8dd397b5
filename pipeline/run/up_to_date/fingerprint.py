"""The fingerprint of a stage: a hash of everything its result depends on."""

from collections.abc import Mapping

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.run.stage_specs import Specs, code_roots, spec_of
from pipeline.run.up_to_date.source_code import code_sha256
from pipeline.stage import Stage
from pipeline.summary.versions import package_version


def fingerprint(specs: Specs, stage: Stage, config: Config, upstream: Mapping[Stage, str]) -> str:
    """Hash a stage's part of the configuration, the results it is given, the package's version and its code.

    The code counts because a working copy changes far more often than its version.

    Parameters
    ----------
    upstream : mapping
        Hash of the result of every upstream stage.
    """
    return config_sha256(
        {
            "stage": stage,
            "config": spec_of(specs, stage).config_part(config),
            "upstream": upstream,
            "version": package_version(),
            "code": code_sha256(code_roots(specs, stage)),
        }
    )

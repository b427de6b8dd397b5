"""Which results of a run folder are up to date."""

from collections.abc import Mapping
from pathlib import Path

from pipeline.artifacts import Record
from pipeline.config import Config
from pipeline.run.stage_specs import Specs, spec_of
from pipeline.run.up_to_date.fingerprint import fingerprint
from pipeline.stage import Stage

Records = Mapping[Stage, Record]


def expected_fingerprint(specs: Specs, stage: Stage, config: Config, records: Records) -> str:
    """Give the fingerprint of a stage that is run now; all it builds on must be there."""
    upstream = _upstream_hashes(specs, stage, records)
    assert upstream is not None, "stages run in order, and a failed one ends the run"
    return fingerprint(specs, stage, config, upstream)


def why_outdated(specs: Specs, stage: Stage, config: Config, records: Records, folder: Path) -> str:
    """Say why the result of a stage cannot be used, as the rest of a sentence; empty if it is up to date."""
    record = records.get(stage)
    if record is None:
        return "has not been run here"
    if record.status == "failed":
        return "failed"
    if not _matches(specs, stage, config, records):
        return "was made with another configuration, version or earlier result"
    if damage := record.damage(folder):
        return f"has files that were removed or changed since ({', '.join(damage)})"
    return ""


def matching_records(specs: Specs, config: Config, records: Records) -> dict[Stage, Record]:
    """Keep the records that match the configuration and the records before them."""
    kept: dict[Stage, Record] = {}
    for spec in specs:
        if spec.stage in records and _matches(specs, spec.stage, config, {**kept, spec.stage: records[spec.stage]}):
            kept[spec.stage] = records[spec.stage]
    return kept


def _matches(specs: Specs, stage: Stage, config: Config, records: Records) -> bool:
    """Check whether a record was made from the configuration, or from a sufficient one, and the records before it."""
    upstream = _upstream_hashes(specs, stage, records)
    if upstream is None:
        return False
    sufficient = spec_of(specs, stage).sufficient(config)
    return records[stage].fingerprint in [fingerprint(specs, stage, one, upstream) for one in sufficient]


def _upstream_hashes(specs: Specs, stage: Stage, records: Records) -> dict[Stage, str] | None:
    """Give the hashes of the results that a stage is given; None if one is missing."""
    hashes: dict[Stage, str] = {}
    for name in spec_of(specs, stage).upstream:
        record = records.get(name)
        if record is None or record.status != "done":
            return None
        hashes[name] = record.files.get(spec_of(specs, name).result, "")
    return hashes

"""The file of a study: what is refused, with the key and what is allowed there."""

from typing import Any

import pytest

from pipeline.errors import ConfigError
from pipeline.study.config import Kind, parse_study

TILTS = {"key": "task.tilt_max_deg", "values": [5, 10]}


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"paramters": []}, r"paramters: is not a known key \(did you mean parameters\?\)"),
        ({"design": {"kind": "gird"}}, r"design.kind: .*'grid'.*'sobol'.*\(it is 'gird'\)"),
        ({"design": {"sampels": 3}}, r"design.sampels: is not a known key \(did you mean samples\?\)"),
        ({"parameters": []}, "which needs parameters"),
        ({"parameters": [{"key": "a"}]}, r"parameters\[0\]: needs either values, or min and max"),
        ({"parameters": [{"values": [1]}]}, r"parameters\[0\]: needs exactly one of key and keys"),
        ({"parameters": [{"keys": ["a", "b"], "values": [[1]]}]}, r"values\[0\] other than a list of 2"),
        ({"parameters": [{"key": "a", "min": 2, "max": 1, "count": 2}]}, "not below max"),
        ({"parameters": [{"key": "a", "min": 0, "max": 1, "count": 2, "log": True}]}, "above 0"),
        ({"parameters": [{"key": "a", "min": 0, "max": 1}]}, r"needs parameters\[0\].count"),
        ({"parameters": [TILTS, TILTS]}, "varies task.tilt_max_deg twice"),
        ({"design": {"kind": "sobol"}}, "needs design.samples"),
        ({"design": {"kind": "list"}}, "needs points, and no parameters"),
        ({"design": {"initial": 3}}, "design: has initial, which only kind optimise uses"),
        ({"design": {"kind": "optimise", "samples": 9}}, "needs in pareto the figures that are optimised"),
        ({"design": {"kind": "optimise", "samples": 10_001}}, "has samples 10,001; kind optimise allows 10,000"),
        ({"design": {"kind": "optimise"}, "pareto": ["a"]}, "needs design.samples for .* optimise"),
        ({"design": {"kind": "optimise", "samples": 9, "sampler": "cma"}}, r"design.sampler: .*'tpe' or 'nsga2'"),
        ({"constraints": [{"figure": "a"}]}, r"constraints\[0\]: needs min, max or both"),
        ({"constraints": [{"figure": "a", "min": 2, "max": 1}]}, "has min 2, which is above max"),
        ({"constraints": [{"figur": "a"}]}, r"constraints\[0\].figur: is not a known key .did you mean figure"),
        ({"run": {"time_limit_s": 0}}, "run.time_limit_s: .*greater than 0"),
        ({"base": 3}, "base: .*string"),
    ],
)
def test_what_is_wrong_is_named(keys: dict[str, Any], said: str) -> None:
    """Every message has the key, and what may stand there."""
    with pytest.raises(ConfigError, match=said):
        parse_study({"base": "quick.yaml", "parameters": [TILTS], **keys})


def test_what_is_left_out_has_a_default() -> None:
    """A base and a parameter are enough, and switches may vary."""
    study = parse_study(
        {"base": "a.yaml", "parameters": [{"key": "figures.pdf", "values": [True, False]}]}, default_name="mine"
    )
    assert (study.name, study.design.kind, study.to) == ("mine", Kind.GRID, "retime")
    assert study.parameters[0].values == (True, False)


def test_the_table_has_what_is_weighed() -> None:
    """Beside the figures that are asked for; where none are, it has all."""
    keys = {"pareto": ["a", "-b"], "constraints": [{"figure": "c", "max": 1}]}
    weighed = {"base": "a.yaml", "parameters": [TILTS], **keys}
    assert parse_study({**weighed, "figures": ["d", "a"]}).kept_figures == ("d", "a", "b", "c")
    assert parse_study(weighed).kept_figures == ()


def test_what_is_not_a_section_is_refused() -> None:
    """A list is no study."""
    with pytest.raises(ConfigError, match="must be a section"):
        parse_study([1])

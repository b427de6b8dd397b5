"""Cases: the configuration of each run, and the key that says whether its result is known."""

from pathlib import Path
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.study.cases import build_cases, parse_case
from pipeline.study.config import load_study
from tests.study.fakes import cases_of

STUDIES = Path(__file__).parents[2] / "configs" / "studies"
SEEDS = {"key": "perturb.seed", "values": [1, 2]}


def keys_of(folder: Path, config: Config, **keys: Any) -> list[str]:
    """Give the keys of a study's cases."""
    return [case.key for case in cases_of(folder, config, **keys)]


def test_a_case_has_the_values_of_its_point(tmp_path: Path, quick_config: Config) -> None:
    """The configuration is the base but for what varies, and is written as the base is: 20 is 20.0."""
    case = list(cases_of(tmp_path, quick_config))[1]
    config, _, _ = parse_case(case.data)
    assert case.point == {"task.tilt_max_deg": 20.0}
    assert config.task.tilt_max_deg == 20.0
    assert config.model_copy(update={"task": quick_config.task, "name": quick_config.name}) == quick_config
    assert config.name.startswith("tilts-")


def test_a_key_is_that_of_content(tmp_path: Path, quick_config: Config) -> None:
    """The same values written otherwise have the same key; another stage or program another one."""
    known = keys_of(tmp_path, quick_config)
    written = {"parameters": [{"key": "task.tilt_max_deg", "min": 10, "max": 30.0, "count": 3}], "name": "other"}
    assert keys_of(tmp_path, quick_config, **written) == known
    assert set(known).isdisjoint(keys_of(tmp_path, quick_config, to="retime"))
    assert set(known).isdisjoint(keys_of(tmp_path, quick_config, program="2"))


def test_deviations_of_the_twin_share_the_motion(tmp_path: Path, quick_config: Config) -> None:
    """Their keys differ only where there is a twin, their folder never does."""
    seeds = {"parameters": [{"key": "twin.seed", "values": [1, 2]}]}
    one, other = cases_of(tmp_path, quick_config, to="simulate", **seeds)
    assert one.folder == other.folder
    assert one.key != other.key


def test_a_perturbed_geometry_follows_from_its_seed(tmp_path: Path, quick_config: Config) -> None:
    """Lengths and joints move by about the standard deviation, angles and travels do not move."""
    perturbed = {"perturb": {"geometry_m": 1e-4}, "parameters": [SEEDS]}
    one, other = (parse_case(case.data)[0] for case in cases_of(tmp_path, quick_config, **perturbed))
    again = parse_case(next(iter(cases_of(tmp_path, quick_config, **perturbed))).data)[0]
    assert one.machine == again.machine != other.machine
    assert 0.0 < abs(one.machine.links.l1.length_m - quick_config.machine.links.l1.length_m) < 1e-3
    assert one.machine.rails[0].travel_m == quick_config.machine.rails[0].travel_m
    assert one.task == quick_config.task


@pytest.mark.parametrize(
    ("parameter", "said"),
    [
        ({"key": "task.tilt_max", "values": [5]}, r"parameters\[0\].values\[0\]: task.tilt_max is not.*tilt_max_deg"),
        (
            {"key": "task.tilt_max_deg", "values": [5, 500]},
            r"values\[1\]: task.tilt_max_deg: is 500.0; allowed is .*85",
        ),
        ({"key": "task.tilt_max_deg", "min": 5, "max": 500, "count": 2}, r"parameters\[0\].max: .*500"),
        ({"key": "task.locked_axes", "values": [["ry"]]}, "allowed is rx or rz"),
        ({"key": "twin.seed", "values": [-1]}, "twin.seed: Input should be greater"),
        ({"key": "name", "values": ["a"]}, "name cannot vary"),
        ({"key": "name[0]", "values": ["a"]}, r"name\[0\] cannot vary"),
        ({"key": "route.alternative", "values": [float("inf")]}, "allowed is a whole number"),
        ({"key": "route.alternative", "values": [float("nan")]}, "allowed is a whole number"),
        ({"key": "route.alternative", "values": [2, 1.4]}, r"values\[1\]: .* is 1.4; allowed is a whole number"),
        ({"keys": ["machine.rails", "machine.rails[0].y_m"], "values": [[[], 1]]}, "varies both machine.rails and"),
    ],
)
def test_what_cannot_vary_so_is_refused(
    tmp_path: Path, quick_config: Config, parameter: dict[str, Any], said: str
) -> None:
    """Before anything runs: unknown paths with the nearest, values with what is allowed, and the place in the file."""
    with pytest.raises(ConfigError, match=said):
        cases_of(tmp_path, quick_config, parameters=[parameter])


def test_a_list_is_checked_too(tmp_path: Path, quick_config: Config) -> None:
    """Its points are named by their places."""
    with pytest.raises(ConfigError, match=r"points\[1\]: task.tilt_max_deg"):
        cases_of(
            tmp_path,
            quick_config,
            design={"kind": "list"},
            points=[{"task.tilt_max_deg": 5}, {"task.tilt_max_deg": 99}],
        )


def test_whole_numbers_of_a_range_are_rounded(tmp_path: Path, quick_config: Config) -> None:
    """Listed ones are whole already, however they are written."""
    for given in ({"min": 1, "max": 3.4, "count": 3}, {"values": [1.0, 2, 3.0]}):
        cases = cases_of(tmp_path, quick_config, parameters=[{"key": "route.alternative", **given}])
        assert [case.point["route.alternative"] for case in cases] == [1, 2, 3]


def test_parameters_do_not_vary_parts_of_each_other(tmp_path: Path, quick_config: Config) -> None:
    """One would undo the other."""
    rails = quick_config.model_dump(mode="json")["machine"]["rails"]
    parameters = [{"key": "machine.rails", "values": [rails]}, {"key": "machine.rails[0].y_m", "values": [0.1]}]
    with pytest.raises(ConfigError, match=r"parameters: varies both machine.rails and machine.rails\[0\].y_m"):
        cases_of(tmp_path, quick_config, parameters=parameters)


@pytest.mark.parametrize("file", sorted(STUDIES.glob("*.yaml")), ids=lambda file: file.stem)
def test_studies_that_come_with_the_program_are_valid(file: Path) -> None:
    """Their keys exist, their values are allowed, and they are named as their files."""
    cases = build_cases(load_study(file), file, "1")
    assert cases.study.name == file.stem
    assert len(cases) > 0

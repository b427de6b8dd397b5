"""The sidecar: it describes the CSV column by column, and says what the machine may do."""

import json
from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import config_sha256, parse_config
from pipeline.export import sidecar, trajectory_columns
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import QUANTITIES, Quantity, TrajectorySamples, Usage


@pytest.fixture
def samples() -> TrajectorySamples:
    """Three rows of nothing in particular."""
    rows = 3
    return TrajectorySamples(
        period_s=0.01,
        t_s=np.arange(rows) * 0.01,
        q_m=np.ones((rows, 5)),
        qd_mps=np.zeros((rows, 5)),
        qdd_mps2=np.zeros((rows, 5)),
        pose=np.zeros((rows, 6)),
        kappa=np.ones(rows),
    )


@pytest.fixture
def described(agder_config: Config, machine: Machine, samples: TrajectorySamples) -> dict:
    """The sidecar of these rows."""
    fractions = {"velocity": np.linspace(0.1, 0.5, 5), "acceleration": np.linspace(0.6, 1.0, 5)}
    return sidecar(agder_config, machine, samples, Usage(fractions))


def test_every_column_has_a_unit_and_a_meaning(described: dict, samples: TrajectorySamples) -> None:
    """Columns are described in the order of the file, none is left out, and units agree with the names."""
    assert [column["name"] for column in described["columns"]] == list(trajectory_columns(samples))
    units = {"_s": "s", "_m": "m", "_mps": "m/s", "_mps2": "m/s^2", "_rad": "rad", "kappa": "1"}
    for column in described["columns"]:
        suffix = column["name"] if column["name"] == "kappa" else "_" + column["name"].rsplit("_", 1)[1]
        assert column["unit"] == units[suffix]
        assert len(column["meaning"]) > 5
    assert len({column["meaning"] for column in described["columns"]}) == len(described["columns"])


def test_it_is_plain_json(described: dict) -> None:
    """It survives the way through JSON without losing anything."""
    assert json.loads(json.dumps(described, allow_nan=False)) == described


def test_it_tells_period_duration_configuration_and_usage(
    described: dict, agder_config: Config, samples: TrajectorySamples
) -> None:
    """Figures are those of the samples; the hash is that of the whole configuration."""
    assert described["period_s"] == 0.01
    assert described["duration_s"] == samples.t_s[-1]
    assert described["samples"] == 3
    assert described["config_sha256"] == config_sha256(agder_config)
    assert described["usage"]["velocity"] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert described["usage"]["acceleration"] == pytest.approx([0.6, 0.7, 0.8, 0.9, 1.0])
    assert any("last row" in sentence for sentence in described["conventions"])


def test_another_quantity_is_listed_with_its_limit(
    agder_config: Config, machine: Machine, samples: TrajectorySamples
) -> None:
    """One more row of what was measured: limits of its own for each actuator or one for all, and usage."""
    own = Quantity("heat", "W", ACTUATORS, limit=lambda _: np.full(5, 7.0), value=lambda path, _: path.q1)
    shared = Quantity("noise", "m/s", ("TCP",), limit=lambda _: np.array([np.inf]), value=lambda path, _: path.q1)
    usage = Usage({"heat": np.full(5, 0.5)}, quantities=(*QUANTITIES, own, shared))
    described = sidecar(agder_config, machine, samples, usage)
    assert described["limits"]["c2"]["heat_w"] == 7.0
    assert described["shared_limits"]["noise_mps"] is None
    assert list(described["usage"])[-2:] == ["heat", "noise"]
    assert (described["usage"]["heat"], described["usage"]["noise"]) == ([0.5] * 5, None)


def test_limits_are_the_machine_s(described: dict, machine: Machine) -> None:
    """Each actuator has travel or stroke, velocity and acceleration, and the column it is found in."""
    assert list(described["limits"]) == ["c1", "c2", "c3", "l2b", "l3b"]
    telescope = described["limits"]["l2b"]
    assert telescope == {
        "column": "q4_m",
        "position_m": [0.95, 1.25],
        "velocity_mps": 0.1,
        "acceleration_mps2": 0.5,
        "jerk_mps3": 10.0,
        "force_n": 1000.0,
    }
    assert described["shared_limits"] == {"link_force_n": 2000.0, "tcp_speed_mps": None, "tcp_acceleration_mps2": None}
    assert [limit["velocity_mps"] for limit in described["limits"].values()] == machine.velocity_mps.tolist()


def test_positions_are_the_controller_s(agder_config: Config, machine: Machine, samples: TrajectorySamples) -> None:
    """Limits of positions are in its units, and what these are in the geometry is listed beside."""
    data = agder_config.model_dump(mode="json")
    data["machine"]["actuators"]["l2b"] = {"zero_m": 3e-4, "scale": 1.001}
    described = sidecar(parse_config(data), machine, samples, Usage({}))
    least, largest = described["limits"]["l2b"]["position_m"]
    given = described["controller"]["l2b"]
    assert given == {"middle_m": pytest.approx(1.1), "zero_m": 3e-4, "scale": 1.001}
    for q, limit in ((least, 0.95), (largest, 1.25)):
        assert given["middle_m"] + given["zero_m"] + given["scale"] * (q - given["middle_m"]) == pytest.approx(limit)
    assert described["controller"]["c1"] == {"middle_m": pytest.approx(1.05, abs=0.2), "zero_m": 0.0, "scale": 1.0}


def test_push_and_pull_are_listed_where_they_differ(
    agder_config: Config, machine: Machine, samples: TrajectorySamples
) -> None:
    """One number for both signs, a section for two."""
    force = machine.force_n.copy()
    force[1, 3] = 800.0
    lopsided = replace(machine, force_n=force, link_force_n=np.array([1_500.0, 2_000.0]))
    described = sidecar(agder_config, lopsided, samples, Usage({}))
    assert described["limits"]["l2b"]["force_n"] == {"push": 1000.0, "pull": 800.0}
    assert described["limits"]["l3b"]["force_n"] == 1000.0
    assert described["shared_limits"]["link_force_n"] == {"push": 1500.0, "pull": 2000.0}

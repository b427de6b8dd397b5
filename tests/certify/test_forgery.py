"""Whatever is changed in a genuine certificate or its path: `--check` refuses it, or it still states what holds."""

import copy
import json
import pathlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.artifacts.layout import CERTIFICATE_JSON, PATH_NPZ
from pipeline.artifacts.npz import npz_bytes, read_npz
from pipeline.artifacts.results.certificate.stored import read_certificate
from pipeline.artifacts.results.path import unpack_path
from pipeline.certify.recheck import Statement, verify
from pipeline.certify.result import path_sha256
from pipeline.config import Config
from pipeline.errors import PipelineError
from pipeline.inclusion.krawczyk import Box
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine import Path, sample_path
from pipeline.route.regions.endpoints import task_endpoints
from tests.certify.audit import cubic, deviations
from tests.certify.runs import Data
from tests.fuzzing import fuzz

STATED_ONLY = ("settings", "versions", "seconds", "precision_bits", "kappa_s", "not_proven_m", "monte_carlo_fails_m")
"""Keys that say how a certificate was made; the README lists them."""
OTHER_TYPES: tuple[object, ...] = (True, False, None, "1", [], {}, [1.0], {"kappa": 1.0})
Place = tuple[str | int, ...]


@dataclass(frozen=True, eq=False)
class Genuine:
    """A certificate that holds, and everything beside it."""

    config: Config
    machine: Machine
    path: Path
    data: Data
    folder: pathlib.Path

    def accepted(self, data: object, path: Path | None = None) -> bool:
        """Check a file with other content; every refusal is one of the errors for users, or a claim."""
        file = self.folder / CERTIFICATE_JSON
        file.write_text(json.dumps(data))
        try:
            stated: Statement = read_certificate(file)
        except PipelineError:
            return False
        claims = verify(self.config, self.machine, path or self.path, task_endpoints(self.config, self.machine), stated)
        return all(claim.verified for claim in claims)


@pytest.fixture(scope="module")
def genuine(
    true_run: pathlib.Path, own_task: Config, machine: Machine, tmp_path_factory: pytest.TempPathFactory
) -> Genuine:
    """Read the true run."""
    path = unpack_path(read_npz(true_run / PATH_NPZ), "", machine)
    data = json.loads((true_run / CERTIFICATE_JSON).read_bytes())
    found = Genuine(own_task, machine, path, data, tmp_path_factory.mktemp("forged"))
    assert found.accepted(data)
    return found


def places(value: object, place: Place = ()) -> Iterator[Place]:
    """List every section, list and value of a file."""
    yield place
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(item, (*place, key))


def read_at(data: Any, place: Place) -> Any:
    """Read one value."""
    for key in place:
        data = data[key]
    return data


def with_value(data: Data, place: Place, value: object) -> Any:
    """Give a copy with another value at one place."""
    changed: Data = copy.deepcopy(data)
    if not place:
        return value
    read_at(changed, place[:-1])[place[-1]] = value
    return changed


def _sample_place(draw: st.DrawFn, data: Data, fits: Callable[[object], bool]) -> Place:
    """Draw a place: a key of the file first, so that its few bounds are drawn as often as its many boxes."""
    where: Place = ()
    while True:
        value = read_at(data, where)
        inside = list(value) if isinstance(value, dict) else list(range(len(value))) if isinstance(value, list) else []
        inside = [key for key in inside if any(fits(read_at(value[key], one)) for one in places(value[key]))]
        if not inside or (fits(value) and where and draw(st.booleans())):
            return where
        where = (*where, draw(st.sampled_from(inside)))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


@st.composite
def another_number(draw: st.DrawFn, data: Data) -> tuple[Place, Any]:
    """Move one number, by a rounding or by far, inward or outward, or replace it."""
    place = _sample_place(draw, data, _is_number)
    value = read_at(data, place)
    step = draw(st.sampled_from([1e-16, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0])) * draw(st.sampled_from([-1.0, 1.0]))
    candidates = [value + step, value * (1.0 + step), -value, 0.0, 0, 1e300, float(np.nextafter(value, step * 1e300))]
    return place, with_value(data, place, draw(st.sampled_from(candidates)))


def stated_only(place: Place) -> bool:
    """Tell whether a place is within what the file only states."""
    return any(key in STATED_ONLY for key in place)


def holds(genuine: Genuine, data: Data) -> bool:
    """Tell whether what a file states is true: of poses by Newton's method at many s, not by anything of the check."""
    samples = sample_path(genuine.path, np.linspace(0.0, 1.0, 501))
    bounds, q = data["bounds"], samples.q_m
    ends = [abs(samples.pose[k] - end.pose).max() for k, end in zip((0, -1), _ends(genuine), strict=True)]
    tilts = np.rad2deg(np.abs(samples.pose[:, [3, 5]]).max(axis=0))
    distances = dict(zip(bounds["distance_m"], samples.link_distances_m.min(axis=0), strict=False))
    forces = samples.holding_forces_n
    return (
        samples.kappa.max() <= bounds["kappa"] <= 100.0
        and bounds["det_sign"] == samples.det_sign[0]
        and all(0.03 <= bounds["distance_m"][name] <= least for name, least in distances.items())
        and all(bounds["actuators_m"][name][0] <= q[:, k].min() for k, name in enumerate(ACTUATORS))
        and all(q[:, k].max() <= bounds["actuators_m"][name][1] for k, name in enumerate(ACTUATORS))
        and tilts[0] <= bounds["tilt_deg"]["rx"]
        and tilts[1] <= bounds["tilt_deg"]["rz"]
        and all(
            low <= of.min() and of.max() <= high
            for of, (low, high) in zip(forces.T, bounds["holding_force_n"].values(), strict=True)
        )
        and ends[0] <= bounds["start_miss"] <= 1e-6
        and ends[1] <= bounds["goal_miss"] <= 1e-6
        and all(_chain_holds(genuine, chain) for chain in data["chains"])
    )


def _ends(genuine: Genuine) -> Any:
    return task_endpoints(genuine.config, genuine.machine)


def _chain_holds(genuine: Genuine, chain: Data) -> bool:
    s, poses = chain["s"], genuine.path.pose(np.array(chain["s"]))
    if (s[0], s[-1]) != (0.0, 1.0) or not (np.diff(s) > 0.0).all():
        return False
    columns = zip(s[:-1], s[1:], chain["pose"], chain["radius"], strict=True)
    boxes = [Box(first, last, np.array(pose), np.array(radius)) for first, last, pose, radius in columns]
    within = (np.abs(poses - chain["joint_pose"]) <= chain["joint_radius"]).all()
    return bool(within) and all((deviations(genuine.path, box) <= box.radius).all() for box in boxes)


@fuzz(30)
@given(data=st.data())
def test_a_number_that_moved_is_refused_or_still_true(genuine: Genuine, data: st.DataObject) -> None:
    """Weaker bounds and larger boxes may still be proven; then samples keep them, and nothing else has changed."""
    place, forged = data.draw(another_number(genuine.data))
    if genuine.accepted(forged):
        assert forged == genuine.data or place[0] in ("bounds", "chains") or stated_only(place)
        assert stated_only(place) or holds(genuine, forged)


@fuzz(30)
@given(data=st.data())
def test_a_value_of_another_type_is_refused(genuine: Genuine, data: st.DataObject) -> None:
    """Truth values are no numbers, texts are none either; nor is anything left out that is not optional."""
    place = _sample_place(data.draw, genuine.data, lambda value: True)
    was, value = read_at(genuine.data, place), data.draw(st.sampled_from(OTHER_TYPES))
    forged = with_value(genuine.data, place, value)
    if genuine.accepted(forged):
        assert stated_only(place) or (value == was and type(value) is type(was)), (place, value)


@fuzz(30)
@given(data=st.data())
def test_keys_and_rows_that_come_and_go_are_refused(genuine: Genuine, data: st.DataObject) -> None:
    """A key left out or added, a row left out, given twice or in another order."""
    place = _sample_place(data.draw, genuine.data, lambda value: isinstance(value, dict | list) and len(value) > 0)
    forged: Data = copy.deepcopy(genuine.data)
    part = read_at(forged, place)
    if isinstance(part, dict):
        key = data.draw(st.sampled_from([*part, "another"]))
        if key in part:
            del part[key]
        else:
            part[key] = 1.0
    else:
        k = data.draw(st.integers(0, len(part) - 1))
        change: Callable[[], Any] = data.draw(
            st.sampled_from([lambda: part.pop(k), lambda: part.insert(k, part[k]), part.reverse])
        )
        change()
    if genuine.accepted(forged):
        assert forged == genuine.data or stated_only(place) or place == () or holds(genuine, forged), place
        if place == () and forged != genuine.data:
            assert set(genuine.data) - set(forged) <= {"settings", "versions", "seconds"}
            assert set(forged) <= set(genuine.data)


@pytest.mark.parametrize("miss", ["start_miss", "goal_miss"])
def test_an_end_is_not_nearer_than_it_is(genuine: Genuine, miss: str) -> None:
    """A miss of zero, or a little below what is found, is refused: what is stated is compared without slack."""
    for stated in (0.0, 1e-300, 1e-13, 1e-12):
        assert not genuine.accepted(with_value(genuine.data, ("bounds", miss), stated))


ARRAYS: dict[str, Callable[[np.ndarray], object]] = {
    "a last bit": lambda array: np.nextafter(array, 9.0),
    "single precision": lambda array: array.astype(np.float32),
    "extended precision": lambda array: array.astype(np.longdouble) * (1 + np.longdouble(2.0) ** -60),
    "an imaginary part": lambda array: array + 1e-3j,
    "no imaginary part": lambda array: array.astype(complex),
    "another shape": np.ravel,
    "one axis more": lambda array: array[..., None],
    "transposed": lambda array: array.T.copy(),
    "one row less": lambda array: array[:-1],
    "the other way round": lambda array: array[::-1],
    "not a number": lambda array: np.where(
        np.arange(len(array)).reshape(-1, *[1] * (array.ndim - 1)) == 1, np.nan, array
    ),
    "truth values": lambda array: array > 0.5,
    "texts": lambda array: array.astype(str),
}


@pytest.mark.parametrize("name", ["knots", "coefficients", "node_s", "node_pose"])
@pytest.mark.parametrize("change", ARRAYS)
def test_another_path_is_refused(genuine: Genuine, machine: Machine, true_run: pathlib.Path, name: str, change: str):
    """Whatever is changed in path.npz: it cannot be read, is another path, or is the same to the last bit."""
    arrays = read_npz(true_run / PATH_NPZ)
    arrays[name] = np.asarray(ARRAYS[change](arrays[name]))
    file = genuine.folder / PATH_NPZ
    file.write_bytes(npz_bytes(arrays))
    try:
        path = unpack_path(read_npz(file), "", machine)
    except (PipelineError, ValueError):
        return
    s = np.linspace(0.0, 1.0, 50)
    if genuine.accepted(genuine.data, path):
        np.testing.assert_array_equal(path.q(s), genuine.path.q(s))
        np.testing.assert_array_equal(path.node_pose, genuine.path.node_pose)


@pytest.mark.parametrize("change", ["shifted", "elsewhere", "another branch"])
def test_poses_of_another_branch_are_refused(genuine: Genuine, change: str) -> None:
    """Known poses are hashed; forged with their hash they still have to lead into the boxes."""
    path = genuine.path
    poses = {
        "shifted": path.node_pose + [0.0, 0.0, 0.0, 0.0, 3.0, 0.0],
        "elsewhere": path.node_pose[::-1] + [0.4, 0.3, -0.5, 1.0, 2.0, 1.0],
        "another branch": path.node_pose * [1.0, 1.0, 1.0, -1.0, 1.0, -1.0] + [0.0, 0.5, 0.5, 2.0, 1.5, 2.0],
    }
    forged = Path(path.machine, path.spline, path.node_s, poses[change])
    assert not genuine.accepted(genuine.data, forged)
    hashed = with_value(genuine.data, ("path_sha256",), path_sha256(forged))
    s, moved = np.linspace(0.0, 1.0, 9), False
    try:
        moved = bool(np.abs(forged.pose(s) - path.pose(s)).max() > 1e-6)
    except PipelineError:
        moved = True
    assert genuine.accepted(hashed, forged) is not moved


def test_samples_tell_what_holds(genuine: Genuine) -> None:
    """The oracle of this file knows a true certificate, and a wrong one."""
    assert holds(genuine, genuine.data)
    assert not holds(genuine, with_value(genuine.data, ("bounds", "kappa"), 1.0))
    first = genuine.data["chains"][0]["pose"][0]
    moved = with_value(genuine.data, ("chains", 0, "pose", 0, 0, 0), first[0][0] + 1e-3)
    assert not holds(genuine, moved)
    box = genuine.data["chains"][0]
    whole = Box(box["s"][0], box["s"][1], np.array(first), np.array(box["radius"][0]))
    assert cubic(whole, np.array([box["s"][0]])).shape == (1, 6)

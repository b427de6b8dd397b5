"""`certify --check` on the command line: a true certificate passes, whatever is forged does not."""

import json
import pathlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline
from typer.testing import CliRunner, Result

from pipeline.artifacts.layout import CONFIG
from pipeline.certify import Certificate, certify_path, path_sha256
from pipeline.cli import app
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config, load_config
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import START, pose_path
from tests.certify.runs import Data, check, forge, write_run


def refused(result: Result) -> list[str]:
    """Give the claims that were not verified."""
    rows = [[cell.strip() for cell in line.split("│")] for line in result.stdout.splitlines()]
    return [row[1] for row in rows if len(row) > 3 and row[2] == "NO"]


def test_a_true_certificate_is_verified(run: pathlib.Path) -> None:
    """What was found is reported: kappa, distances, travel, tilts, both tolerances."""
    result = check(run)
    assert result.exit_code == 0, result.stdout
    assert refused(result) == []
    for reported in (
        "cap 100",
        "required 0.03",
        "limits 0.005 to 2.095 m",
        "limit 30 degrees",
        "stated 0.1 mm",
        "stated 0.02 mm",
    ):
        assert reported in result.stdout


def test_a_run_folder_stands_for_its_certificate(run: pathlib.Path) -> None:
    """The folder is what one has at hand."""
    result = CliRunner().invoke(app, ["certify", "--check", str(run)])
    assert result.exit_code == 0, result.output
    assert refused(result) == []


def _tell_more(data: Data) -> None:
    data["tolerance_m"] = data["tolerances"]["link_length"]["proven_m"] = 0.5


def _without_a_box(data: Data) -> None:
    chain = data["chains"][0]
    for key, k in (("pose", 3), ("radius", 3), ("s", 4), ("joint_pose", 4), ("joint_radius", 4)):
        del chain[key][k]


def _without_the_last_box(data: Data) -> None:
    for key in ("s", "pose", "radius", "joint_pose", "joint_radius"):
        del data["chains"][0][key][-1]
    data["boxes"] -= 1


FORGED: dict[str, tuple[Callable[[Data], object], str]] = {
    "no chain": (lambda data: data.update(chains=[]), "the first chain is of the configured machine"),
    "nothing but uncertain chains": (
        lambda data: data["chains"].pop(0),
        "the first chain is of the configured machine",
    ),
    "the configured machine twice": (
        lambda data: data["chains"].insert(0, data["chains"][0]),
        "the tolerance of link lengths has its chain",
    ),
    "a tolerance without its chain": (
        lambda data: data["chains"].pop(1),
        "the tolerance of link lengths has its chain",
    ),
    "a tolerance of coordinates without its chain": (
        lambda data: data["chains"].pop(2),
        "the tolerance of coordinates has its chain",
    ),
    "a tolerance with two chains": (
        lambda data: data["chains"].append(data["chains"][1]),
        "the tolerance of link lengths has its chain",
    ),
    "a tolerance beyond its chain": (_tell_more, "the tolerance of link lengths has its chain"),
    "a tolerance that is not stated": (
        lambda data: (data.update(tolerance_m=None), data["tolerances"].update(link_length=None)),
        "the tolerance of link lengths has its chain",
    ),
    "a chain for more than was proven": (
        lambda data: (_tell_more(data), data["chains"][1]["uncertainty"].update(length_m=0.5)),
        "lengths ± 500, coordinates ± 0 mm: each box holds one regular pose",
    ),
    "more boxes than there are": (
        lambda data: data.update(boxes=9_999),
        "the first chain is of the configured machine",
    ),
    "more boxes of a tolerance": (
        lambda data: data["tolerances"]["coordinates"].update(boxes=9_999),
        "the tolerance of coordinates has its chain",
    ),
    "a box left out": (_without_a_box, "configured machine: each box holds one regular pose"),
    "the last box left out": (_without_the_last_box, "configured machine: boxes cover s = 0 to 1"),
    "another path": (lambda data: data.update(path_sha256="0" * 64), "the certificate is of this path"),
    "another machine": (
        lambda data: data.update(premises_sha256="0" * 64),
        "the certificate is of this machine, limits, start and goal",
    ),
    "a bound of kappa above the cap": (
        lambda data: data["bounds"].update(kappa=1e6),
        "kappa stays below its bound, within the cap",
    ),
    "a bound of kappa below the truth": (
        lambda data: data["bounds"].update(kappa=1.0),
        "kappa stays below its bound, within the cap",
    ),
    "no distance": (lambda data: data["bounds"].update(distance_m={}), "axes keep their required distances"),
    "a distance missing": (
        lambda data: data["bounds"]["distance_m"].popitem(),
        "axes keep their required distances",
    ),
    "distances below what is asked for": (
        lambda data: data["bounds"].update(distance_m=dict.fromkeys(data["bounds"]["distance_m"], 0.0)),
        "axes keep their required distances",
    ),
    "travel beyond the rail": (
        lambda data: data["bounds"]["actuators_m"].update(c2=[-1.0, 3.0]),
        "carts and telescopes stay within bounds and limits",
    ),
    "tilts beyond their limit": (
        lambda data: data["bounds"]["tilt_deg"].update(rx=89.0),
        "tilts stay within bounds and limits",
    ),
    "another sign of det H": (lambda data: data["bounds"].update(det_sign=-1), "det H keeps its sign"),
    "a goal that is missed": (
        lambda data: data["bounds"].update(goal_miss=0.1),
        "the goal is the task's: its pose, mode and branch",
    ),
    "numbers too large to compute with": (
        lambda data: data["chains"][0]["pose"][2][0].__setitem__(0, 1e300),
        "configured machine: each box holds one regular pose",
    ),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_certificate_is_not_verified(run: pathlib.Path, name: str) -> None:
    """Exit 1, the claim that does not hold in the table, and what to do."""
    change, claim = FORGED[name]
    forge(run, change)
    result = check(run)
    assert result.exit_code == 1
    assert claim in refused(result)
    assert "does not hold" in result.stderr
    assert "What to change" in result.stderr


def test_another_configuration_is_found(run: pathlib.Path, own_task: Config) -> None:
    """A cap that the path keeps as well is another premise; the configuration's hash is forged with it."""
    forged = own_task.model_copy(update={"route": own_task.route.model_copy(update={"kappa_max": 99.0})})
    (run / CONFIG).write_text(dump_config(forged))
    assert load_config(run / CONFIG) == forged
    state = json.loads((run / "state.json").read_text())
    (run / "state.json").write_text(json.dumps({**state, "config_sha256": config_sha256(forged)}))
    result = check(run)
    assert result.exit_code == 1
    assert refused(result) == ["the certificate is of this machine, limits, start and goal"]


@pytest.fixture(scope="module")
def one_box(own_task: Config, machine: Machine, goal: np.ndarray) -> tuple[Path, Certificate]:
    """Certify a path of one piece by one box over all of it."""
    path = pose_path(machine, np.linspace(START, goal, 6), 0, 6)
    certify = own_task.certify.model_copy(update={"kappa_excess": 10.0})
    certificate = certify_path(own_task.model_copy(update={"certify": certify}), machine, path)
    assert len(certificate.chain.boxes) == 1
    return path, certificate


SPLINES: dict[str, tuple[Callable[[BSpline], BSpline], str]] = {
    "an excursion beyond a knot": (
        lambda spline: bent(spline.insert_knot(0.3, 5), 7, 0.3),
        "configured machine: each box holds one regular pose",
    ),
    "a jump": (
        lambda spline: bent(doubled(spline.insert_knot(0.5, 5)), slice(6, 12), 1e-12),
        "the splines are continuous from s = 0 to 1",
    ),
    "a domain of its own": (
        lambda spline: BSpline(1.25 * spline.t, spline.c, 5),
        "the splines are continuous from s = 0 to 1",
    ),
}


def bent(spline: BSpline, rows: int | slice, by: float) -> BSpline:
    """Move coefficients of telescope 2b."""
    coefficients = spline.c.copy()
    coefficients[rows, 3] += by
    return BSpline(spline.t, coefficients, spline.k)


def doubled(spline: BSpline) -> BSpline:
    """Let a knot at 1/2 be once more, with one value on both sides of it."""
    k = int(np.searchsorted(spline.t, 0.5))
    return BSpline(np.insert(spline.t, k, 0.5), np.insert(spline.c, k - 1, spline.c[k - 1], axis=0), spline.k)


@pytest.mark.parametrize("name", SPLINES)
def test_splines_that_do_something_else_between_boxes_are_found(
    tmp_path: pathlib.Path, own_task: Config, one_box: tuple[Path, Certificate], name: str
) -> None:
    """The one box says nothing about what splines do beyond a knot; the forged file has the right hash."""
    path, certificate = one_box
    change, claim = SPLINES[name]
    forged = replace(path, spline=change(path.spline))
    write_run(tmp_path / "true", own_task, path, certificate)
    assert check(tmp_path / "true").exit_code == 0
    write_run(tmp_path / "forged", own_task, forged, replace(certificate, path_sha256=path_sha256(forged)))
    result = check(tmp_path / "forged")
    assert result.exit_code == 1
    assert claim in refused(result)

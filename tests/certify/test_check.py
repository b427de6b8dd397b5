"""`certify --check` on the command line: a true certificate passes, whatever is forged or damaged does not."""

import json
import pathlib
import shutil
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline
from typer.testing import CliRunner, Result

from pipeline.artifacts import State, open_run_folder
from pipeline.artifacts.certificate import certificate_bytes
from pipeline.artifacts.layout import CERTIFICATE_JSON, CONFIG, PATH_NPZ
from pipeline.artifacts.pack import npz_bytes, pack_refinement
from pipeline.certify import Certificate, Tolerance, certify_path, path_sha256
from pipeline.certify.chain import close_chain, examine_nothing
from pipeline.certify.closure import geometry, working_precision
from pipeline.certify.pieces import pieces
from pipeline.certify.result import proven_chain
from pipeline.certify.uncertainty import Uncertainty, of_everything, of_lengths
from pipeline.cli import app
from pipeline.config import Config
from pipeline.config_file import config_sha256, dump_config, load_config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.refine.result import Refinement
from pipeline.status import Status
from tests.certify.paths import START, pose_path

Check = Callable[..., Result]
Data = dict[str, Any]


def write_run(folder: pathlib.Path, config: Config, path: Path, certificate: Certificate) -> None:
    """Write what a run leaves behind of a path and its certificate."""
    refinement = Refinement(path, path, Status.CONVERGED, 1, 1, 1, None, 1, 0.0)
    files = {
        PATH_NPZ: npz_bytes(pack_refinement(refinement)),
        CERTIFICATE_JSON: certificate_bytes(certificate, {"seconds": 1.0}),
    }
    with open_run_folder(folder) as run:
        run.change(State(config_sha256=config_sha256(config)), files, [], dump_config(config), {})


def bear(path: Path, uncertainty: Uncertainty) -> Tolerance:
    """Prove one calibration error to be borne."""
    with working_precision(64):
        chain = close_chain(geometry(path.machine), path, pieces(path.spline), 1e-4, examine_nothing, uncertainty)
    assert chain.broken is None
    return Tolerance(uncertainty.length_m, 2.0 * uncertainty.length_m, np.inf, proven_chain(chain, uncertainty))


@pytest.fixture(scope="module")
def goal() -> np.ndarray:
    """Say where the task of these tests ends."""
    return np.array([1.05, 0.33, 0.88, *np.deg2rad([2.0, -1.0])])


@pytest.fixture(scope="module")
def true_run(
    tmp_path_factory: pytest.TempPathFactory, own_task: Config, machine: Machine, goal: np.ndarray
) -> pathlib.Path:
    """Certify a path of six pieces, with both tolerances, and write it as a run does."""
    path = pose_path(machine, np.linspace(START, goal, 11), 0, 11)
    certificate = certify_path(own_task, machine, path)
    certificate = replace(
        certificate, link_length=bear(path, of_lengths(1e-4)), coordinates=bear(path, of_everything(2e-5))
    )
    folder = tmp_path_factory.mktemp("runs") / "true"
    write_run(folder, own_task, path, certificate)
    return folder


@pytest.fixture
def run(true_run: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    """Give a copy of the true run, to be forged."""
    return pathlib.Path(shutil.copytree(true_run, tmp_path / "run"))


def check(folder: pathlib.Path) -> Result:
    """Call the command line; whatever is not told in words is raised."""
    result = CliRunner().invoke(app, ["certify", "--check", str(folder / CERTIFICATE_JSON)], env={"COLUMNS": "400"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def forge(folder: pathlib.Path, change: Callable[[Data], object]) -> None:
    """Change what a certificate says."""
    file = folder / CERTIFICATE_JSON
    data = json.loads(file.read_bytes())
    change(data)
    file.write_text(json.dumps(data))


def refused(result: Result) -> list[str]:
    """Give the claims that were not verified."""
    rows = [[cell.strip() for cell in line.split("│")] for line in result.stdout.splitlines()]
    return [row[1] for row in rows if len(row) > 3 and row[2] == "NO"]


def test_a_true_certificate_is_verified(run: pathlib.Path) -> None:
    """And what was found is told: kappa, distances, travel, tilts, both tolerances."""
    result = check(run)
    assert result.exit_code == 0, result.stdout
    assert refused(result) == []
    for told in (
        "cap 100",
        "asked for 0.03",
        "limits 0 to 2.1 m",
        "limit 30 degrees",
        "stated 0.1 mm",
        "stated 0.02 mm",
    ):
        assert told in result.stdout


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
    "no chain": (lambda data: data.update(chains=[]), "its first chain is of the configured machine"),
    "nothing but uncertain chains": (
        lambda data: data["chains"].pop(0),
        "its first chain is of the configured machine",
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
        "lengths ± 500, coordinates ± 0 mm: each holds one pose, regular",
    ),
    "more boxes than there are": (
        lambda data: data.update(boxes=9_999),
        "its first chain is of the configured machine",
    ),
    "more boxes of a tolerance": (
        lambda data: data["tolerances"]["coordinates"].update(boxes=9_999),
        "the tolerance of coordinates has its chain",
    ),
    "a box left out": (_without_a_box, "configured machine: each holds one pose, regular"),
    "the last box left out": (_without_the_last_box, "configured machine: boxes reach from s = 0 to 1"),
    "another path": (lambda data: data.update(path_sha256="0" * 64), "it is about this path"),
    "another machine": (
        lambda data: data.update(premises_sha256="0" * 64),
        "it is about this machine, limits, start and goal",
    ),
    "a bound of kappa above the cap": (
        lambda data: data["bounds"].update(kappa=1e6),
        "kappa stays below its bound, within the cap",
    ),
    "a bound of kappa below the truth": (
        lambda data: data["bounds"].update(kappa=1.0),
        "kappa stays below its bound, within the cap",
    ),
    "no distance": (lambda data: data["bounds"].update(distance_m={}), "axes keep their distances, as asked for"),
    "a distance missing": (
        lambda data: data["bounds"]["distance_m"].popitem(),
        "axes keep their distances, as asked for",
    ),
    "distances below what is asked for": (
        lambda data: data["bounds"].update(distance_m=dict.fromkeys(data["bounds"]["distance_m"], 0.0)),
        "axes keep their distances, as asked for",
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
        "the goal is the task's, its mode and branch too",
    ),
    "numbers too large to compute with": (
        lambda data: data["chains"][0]["pose"][2][0].__setitem__(0, 1e300),
        "configured machine: each holds one pose, regular",
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


def _set(*keys: str | int, to: object) -> Callable[[Data], object]:
    def change(data: Any) -> None:
        for key in keys[:-1]:
            data = data[key]
        data[keys[-1]] = to

    return change


DAMAGED: dict[str, tuple[Callable[[Data], object], str]] = {
    "no bound of kappa": (_set("bounds", "kappa", to=None), "bounds.kappa: is null; there has to be a number"),
    "words for a bound": (_set("bounds", "kappa", to="30"), 'bounds.kappa: is "30"; there has to be a number'),
    "no bounds": (_set("bounds", to=None), "bounds: is null; there has to be a section"),
    "another format": (_set("format", to=99), "is of format 99; this version reads format 2"),
    "the format before": (_set("format", to=1), "is of format 1; this version reads format 2"),
    "no format": (lambda data: data.pop("format"), "names no format; this version reads format 2"),
    "another verdict": (_set("verdict", to="perhaps"), "verdict: is \"perhaps\"; there has to be 'certified'"),
    "a refusal": (_set("verdict", to="not certified"), "says that the path is not certified"),
    "a refusal that is certified": (_set("refused_at_s", to=0.5), "refused_at_s: is 0.5; there has to be null"),
    "a key left out": (lambda data: data["bounds"].pop("det_sign"), "bounds.det_sign: is missing"),
    "a key that is not known": (_set("tolerance_mm", to=99), "tolerance_mm: is not a key of this format"),
    "no sign": (_set("bounds", "det_sign", to=0), "bounds.det_sign: is 0; there has to be -1 or 1"),
    "an uncertainty below zero": (
        _set("chains", 1, "uncertainty", "length_m", to=-0.5),
        "chains[1].uncertainty.length_m: is -0.5; there has to be a number of at least 0",
    ),
    "a tolerance below zero": (
        _set("tolerances", "link_length", "proven_m", to=-1.0),
        "tolerances.link_length.proven_m: is -1.0; there has to be a number of at least 0",
    ),
    "two tolerances": (_set("tolerance_m", to=0.5), "tolerance_m: is 0.5, but proven_m within tolerances is 0.0001"),
    "a radius below zero": (_set("chains", 0, "radius", 0, 0, to=-1.0), "chains[0].radius[0][0]: is -1.0"),
    "s beyond the path": (_set("chains", 0, "s", 0, to=-0.25), "chains[0].s[0]: is -0.25"),
    "a cubic of one coordinate": (_set("chains", 0, "pose", 0, to=[[0.0] * 6]), "chains[0].pose[0]: is a list of 1"),
    "poses left out": (lambda data: data["chains"][0]["pose"].pop(), "chains[0].pose: has"),
    "boxes left out": (
        lambda data: data["chains"][0].update(s=[], pose=[], radius=[], joint_pose=[], joint_radius=[]),
        "chains[0].s: is a list of 0 entries; there has to be a list of at least 2 entries",
    ),
    "chains that are none": (_set("chains", to=7), "chains: is 7; there has to be a list"),
    "a hash that is none": (
        _set("path_sha256", to="yes"),
        'path_sha256: is "yes"; there has to be 64 hexadecimal digits',
    ),
    "a number without end": (_set("bounds", "kappa", to=10**400), "bounds.kappa: is 1000"),
    "many faults": (_set("chains", 0, "radius", to=[[-1.0] * 6] * 9), "more"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_certificate_is_told_key_by_key(run: pathlib.Path, name: str) -> None:
    """Exit 2, which key, what is there, what has to be, and what to do."""
    change, told = DAMAGED[name]
    forge(run, change)
    result = check(run)
    assert result.exit_code == 2
    assert told in result.stderr
    assert "What to change: certify the path again" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"kappa": ', '"kappa": NaN, "was": ', "holds NaN where a number has to be"),
        ('"length_m": 0.0001', '"length_m": NaN', "holds NaN where a number has to be"),
        ('"seconds": 1.0', '"seconds": -Infinity', "holds -Infinity where a number has to be"),
        ('"seconds": 1.0', '"seconds": 1e999', "seconds: is Infinity; there has to be a finite number"),
        ('"boxes": ', '"boxes": 1, "boxes": ', "has the key boxes twice in one section"),
        ('"bounds"', "bounds", "is damaged: it is no JSON from line "),
        ("{", "", "is damaged: it is no JSON from line "),
    ],
)
def test_a_file_that_is_no_json_of_numbers_is_told(run: pathlib.Path, old: str, new: str, told: str) -> None:
    """Exit 2, in words."""
    file = run / CERTIFICATE_JSON
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    result = check(run)
    assert result.exit_code == 2
    assert told in result.stderr


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"", b"[]", b"7", b"[" * 100_000])
def test_a_file_that_is_something_else_is_told(run: pathlib.Path, content: bytes) -> None:
    """Exit 2, without a traceback."""
    (run / CERTIFICATE_JSON).write_bytes(content)
    result = check(run)
    assert result.exit_code == 2
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
    assert refused(result) == ["it is about this machine, limits, start and goal"]


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
        "configured machine: each holds one pose, regular",
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

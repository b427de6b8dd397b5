"""`certify --check` on the command line: files that are damaged are reported key by key, with exit code 2."""

import pathlib
from collections.abc import Callable
from typing import Any

import pytest

from pipeline.artifacts.layout import CERTIFICATE_JSON
from tests.certify.runs import Data, check, forge


def _set(*keys: str | int, to: object) -> Callable[[Data], object]:
    def change(data: Any) -> None:
        for key in keys[:-1]:
            data = data[key]
        data[keys[-1]] = to

    return change


DAMAGED: dict[str, tuple[Callable[[Data], object], str]] = {
    "no bound of kappa": (_set("bounds", "kappa", to=None), "bounds.kappa: is null; expected a number"),
    "words for a bound": (_set("bounds", "kappa", to="30"), 'bounds.kappa: is "30"; expected a number'),
    "no bounds": (_set("bounds", to=None), "bounds: is null; expected a section"),
    "another format": (_set("format", to=99), "is of format 99; this version reads format 3"),
    "the format before": (_set("format", to=2), "is of format 2; this version reads format 3"),
    "a format that only equals it": (_set("format", to=3.0), "is of format 3.0; this version reads format 3"),
    "no format": (lambda data: data.pop("format"), "names no format; this version reads format 3"),
    "another verdict": (_set("verdict", to="perhaps"), "verdict: is \"perhaps\"; expected 'certified'"),
    "a refusal": (_set("verdict", to="not certified"), "says that the path is not certified"),
    "a refusal that is certified": (_set("refused_at_s", to=0.5), "refused_at_s: is 0.5; expected null"),
    "a key left out": (lambda data: data["bounds"].pop("det_sign"), "bounds.det_sign: is missing"),
    "a key that is not known": (_set("tolerance_mm", to=99), "tolerance_mm: is not a key of this format"),
    "no sign": (_set("bounds", "det_sign", to=0), "bounds.det_sign: is 0; expected -1 or 1"),
    "an uncertainty below zero": (
        _set("chains", 1, "uncertainty", "length_m", to=-0.5),
        "chains[1].uncertainty.length_m: is -0.5; expected a number of at least 0",
    ),
    "a tolerance below zero": (
        _set("tolerances", "link_length", "proven_m", to=-1.0),
        "tolerances.link_length.proven_m: is -1.0; expected a number of at least 0",
    ),
    "two tolerances": (_set("tolerance_m", to=0.5), "tolerance_m: is 0.5, but proven_m within tolerances is 0.0001"),
    "a radius below zero": (_set("chains", 0, "radius", 0, 0, to=-1.0), "chains[0].radius[0][0]: is -1.0"),
    "s beyond the path": (_set("chains", 0, "s", 0, to=-0.25), "chains[0].s[0]: is -0.25"),
    "a cubic of one coordinate": (_set("chains", 0, "pose", 0, to=[[0.0] * 6]), "chains[0].pose[0]: is a list of 1"),
    "poses left out": (lambda data: data["chains"][0]["pose"].pop(), "chains[0].pose: has"),
    "boxes left out": (
        lambda data: data["chains"][0].update(s=[], pose=[], radius=[], joint_pose=[], joint_radius=[]),
        "chains[0].s: is a list of 0 entries; expected a list of at least 2 entries",
    ),
    "chains that are none": (_set("chains", to=7), "chains: is 7; expected a list"),
    "a hash that is none": (
        _set("path_sha256", to="yes"),
        'path_sha256: is "yes"; expected 64 hexadecimal digits',
    ),
    "a number without end": (_set("bounds", "kappa", to=10**400), "bounds.kappa: is 1000"),
    "many faults": (lambda data: data.update({f"key {k}": k for k in range(9)}), "and 4 more"),
    "a thousand faults in a list": (
        _set("chains", 0, "radius", to=[[-1.0] * 6] * 1_000),
        "chains[0].radius[0][0]: is -1.0",
    ),
    "a truth value for a sign": (_set("bounds", "det_sign", to=True), "bounds.det_sign: is true; expected"),
    "a fraction for a sign": (_set("bounds", "det_sign", to=1.0), "bounds.det_sign: is 1.0; expected"),
    "a truth value for a number": (_set("bounds", "kappa", to=True), "bounds.kappa: is true; expected a number"),
    "a truth value for a count": (_set("boxes", to=True), "boxes: is true; expected a whole number"),
    "a truth value in a list": (
        _set("chains", 0, "pose", 0, 0, 0, to=True),
        "chains[0].pose[0][0][0]: is true; expected a number",
    ),
    "far too many chains": (lambda data: data.update(chains=data["chains"] * 10), "chains: is a list of 30 entries"),
    "far too many boxes": (
        lambda data: data["chains"][0].update(radius=[0] * 150_001),
        "boxes; at most 150,000 are verified",
    ),
    "far too many keys": (
        lambda data: data["bounds"].update(distance_m={f"links {k}": 1.0 for k in range(2_000)}),
        "has a section of 2,000 keys; at most 1,000 are read",
    ),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_certificate_is_reported_key_by_key(run: pathlib.Path, name: str) -> None:
    """Exit 2, which key, what is there, what has to be, and what to do."""
    change, reported = DAMAGED[name]
    forge(run, change)
    result = check(run)
    assert result.exit_code == 2
    assert reported in result.stderr
    assert "What to change: certify the path again" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ('"kappa": ', '"kappa": NaN, "was": ', "holds NaN where a number is expected"),
        ('"length_m": 0.0001', '"length_m": NaN', "holds NaN where a number is expected"),
        ('"seconds": 1.0', '"seconds": -Infinity', "holds -Infinity where a number is expected"),
        ('"seconds": 1.0', '"seconds": 1e999', "seconds: is Infinity; expected a finite number"),
        ('"boxes": ', '"boxes": 1, "boxes": ', "has the key boxes twice in one section"),
        ('"bounds"', "bounds", "is damaged: it is not JSON from line "),
        ("{", "", "is damaged: it is not JSON from line "),
    ],
)
def test_a_file_that_is_not_json_of_numbers_is_reported(run: pathlib.Path, old: str, new: str, reported: str) -> None:
    """Exit 2, in words."""
    file = run / CERTIFICATE_JSON
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    result = check(run)
    assert result.exit_code == 2
    assert reported in result.stderr


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"", b"[]", b"7", b"[" * 100_000])
def test_a_file_that_is_something_else_is_reported(run: pathlib.Path, content: bytes) -> None:
    """Exit 2, without a traceback."""
    (run / CERTIFICATE_JSON).write_bytes(content)
    result = check(run)
    assert result.exit_code == 2
    assert "What to change" in result.stderr


@pytest.mark.parametrize("kept", [(), ("config.yaml",), ("config.yaml", "state.json")])
def test_what_is_missing_beside_it_is_said_before_it_is_read(
    run: pathlib.Path, tmp_path: pathlib.Path, kept: tuple[str, ...]
) -> None:
    """A certificate outside its run is not read to the end, whatever is in it."""
    for name in kept:
        (tmp_path / name).write_bytes((run / name).read_bytes())
    (tmp_path / CERTIFICATE_JSON).write_text("{")
    result = check(tmp_path)
    assert result.exit_code == 2
    assert str(tmp_path) in result.stderr
    assert "damaged" not in result.stderr

"""The page: one file that loads nothing, is not too large, escapes what it is given, and shows what failed."""

import base64
import gzip
import hashlib
import html
import itertools
import json
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.pose_error import DriveAmplification, PoseError, SampledError
from pipeline.report import Report, RunResults, StageFacts, build_report, render_page
from pipeline.stage import Stage

_POLICY = ("default-src 'none'", "img-src data: blob:", "base-uri 'none'", "form-action 'none'")
ROOT = Path(__file__).parents[2]
_VOID = {"meta", "link", "input", "br", "img", "hr"}


class Outline(HTMLParser):
    """What a page consists of: all tags with their attributes, texts by tag, and whether tags close in order."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.open: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element and that it is open."""
        self.tags.append((tag, dict(attrs)))
        if tag not in _VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """Close the element opened last."""
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data: str) -> None:
        """Keep text by the element it is in."""
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)

    def attributes(self, name: str) -> list[str]:
        """Give all values of an attribute."""
        return [value or "" for _, attributes in self.tags for key, value in attributes.items() if key == name]


@pytest.fixture(scope="module")
def outline(page: str) -> Outline:
    """Parse the page of the whole run."""
    return Outline(page)


def test_the_page_is_well_formed(outline: Outline, page: str) -> None:
    """Every element is closed, in order; identifiers are unique, and labels name what there is."""
    assert page.startswith("<!doctype html>")
    assert outline.open == []
    identifiers = outline.attributes("id")
    assert len(identifiers) == len(set(identifiers))
    assert set(outline.attributes("aria-labelledby")) | set(outline.attributes("for")) <= set(identifiers)


def test_nothing_is_loaded(outline: Outline, page: str) -> None:
    """No element refers to anything outside the page, and the page forbids its scripts to load anything."""
    for attribute in ("src", "href", "srcset", "data", "action", "poster"):
        assert all(value.startswith(("#", "data:")) for value in outline.attributes(attribute))
    styles = "".join(outline.texts["style"])
    assert "url(" not in styles
    assert "@import" not in styles
    assert set(_POLICY) <= set(policy_of(outline))


def policy_of(outline: Outline) -> list[str]:
    """Give the directives of the policy that the page states."""
    (policy,) = (attributes["content"] for _, attributes in outline.tags if attributes.get("http-equiv"))
    assert policy is not None
    return policy.split("; ")


def test_only_the_scripts_and_styles_of_the_page_may_run(outline: Outline, page: str) -> None:
    """The policy names them by their hashes, and nothing unsafe; there is no code or style in any attribute."""
    script, library = _scripts(outline)[2], get_plotlyjs()
    (style,) = outline.texts["style"]
    allowed = dict(directive.split(" ", 1) for directive in policy_of(outline))
    assert allowed["script-src"].split() == [_hash(script), _hash(library)]
    assert allowed["style-src"].split() == [_hash(style), _hash("")]
    assert len(allowed) == 6
    assert outline.attributes("style") == []
    assert not any(name.startswith("on") for _, attributes in outline.tags for name in attributes)


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _scripts(outline: Outline) -> list[str]:
    """Give the numbers and the library, both packed, and the script of the page."""
    assert [attributes.get("type") for tag, attributes in outline.tags if tag == "script"] == [
        "application/gzip",
        "application/gzip",
        None,
    ]
    return outline.texts["script"]


def _unpacked(text: str) -> str:
    return gzip.decompress(base64.b64decode(text, validate=True)).decode()


def test_installed_packages_have_the_assets() -> None:
    """Template, styles and scripts are declared as data of the package, so that a wheel has them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    patterns = settings["tool"]["setuptools"]["package-data"]["pipeline.report"]
    package = ROOT / "pipeline" / "report"
    assets = {path for path in package.rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")}
    assert assets == {path for pattern in patterns for path in package.glob(pattern)}
    assert len(assets) > 2


def test_size(page: str, outline: Outline) -> None:
    """The page is less than four megabytes, and without the drawing library less than one and a half."""
    assert len(page.encode()) < 4e6
    assert len(page.encode()) - len(_scripts(outline)[1]) < 1.5e6


def test_the_library_is_complete(outline: Outline) -> None:
    """What is unpacked in the browser is the drawing library, to the letter."""
    assert _unpacked(_scripts(outline)[1]) == get_plotlyjs()


def test_the_summary_stands_before_all_scripts(page: str) -> None:
    """What people read first does not wait for the drawing library."""
    assert page.index("Certified") < page.index('id="motion"') < page.index("<script")
    assert page.index("Usable workspace") < page.index("<script")


def test_the_numbers_are_strict_json(outline: Outline) -> None:
    """The numbers are there as JSON without NaN, the refined motion first."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    data = json.loads(_unpacked(_scripts(outline)[0]), parse_constant=refuse)
    assert list(data["motions"]) == ["refined", "coarse"]
    assert set(data) == {"themes", "mapColours", "names", "scene", "motions", "proof"}


def test_the_same_report_makes_the_same_page(report: Report, page: str) -> None:
    """There is nothing in the page that the report does not say, such as a date."""
    assert render_page(report) == page


def test_text_of_the_user_stays_text(complete: RunResults) -> None:
    """Whatever the configuration holds, none of it becomes an element, an attribute or a script."""
    evil = "\"><script>alert(1)</script><img src=x onerror=alert(1)>'{{ 7*7 }}</script>&"
    config = complete.config.model_copy(
        update={
            "name": evil,
            "export": complete.config.export.model_copy(
                update={"joint_names": (evil, *complete.config.export.joint_names[1:])}
            ),
        }
    )
    # Without its motion, whose numbers are not the user's to write.
    run = replace(complete, config=config, versions={evil: evil}, trajectory=None)
    written = render_page(build_report(run))
    outline = Outline(written)
    assert outline.open == []
    assert {attributes.get("class") for tag, attributes in outline.tags if tag == "img"} == {"picture"}
    assert not any(name.startswith("on") for _, attributes in outline.tags for name in attributes)
    assert _scripts(outline)[2].startswith('"use strict";')
    assert evil in "".join(outline.texts["h1"])
    assert "49" not in "".join(outline.texts["h1"])


@pytest.mark.parametrize("stage", [Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY, Stage.RETIME])
def test_a_failed_stage_is_shown_as_failed(
    complete: RunResults, failed_at: Callable[[RunResults, Stage], RunResults], stage: Stage
) -> None:
    """The page of a run that failed says so first, with the reason and what to change, and shows no motion."""
    report = build_report(failed_at(complete, stage))
    written = render_page(report)
    outline = Outline(written)
    assert outline.open == []
    assert report.headline.mood == "bad"
    assert report.motions == ()
    assert {row.name: row.status for row in report.stages}[stage] == "failed"
    assert all(row.status == "not run" for row in report.stages if row.name in stage.later)
    text = " ".join(text for texts in outline.texts.values() for text in texts)
    assert "the <reason> & more" in text.lower()
    assert "change <this>" in text
    assert "Exit code 1" in text
    assert "Certified" not in "".join(outline.texts["strong"])
    assert f"There is no motion to show: {stage} failed." in text


def test_a_failed_certificate_is_no_certificate(
    complete: RunResults, failed_at: Callable[[RunResults, Stage], RunResults]
) -> None:
    """Where the proof failed, the first words are that the path is not certified, and no bounds are shown."""
    report = build_report(failed_at(complete, Stage.CERTIFY))
    assert report.headline.answer == "Not certified"
    assert report.bounds is report.proof is None
    assert report.comparison is not None


def test_a_run_without_proof_is_not_called_certified(complete: RunResults) -> None:
    """A motion that nothing was proven of is shown, but never called certified."""
    skipped = StageFacts(False, {"status": "skipped", "verdict": "skipped"})
    run = replace(complete, facts={**complete.facts, Stage.CERTIFY: skipped}, bounds=None, profile=None)
    report = build_report(run)
    assert report.headline.mood == "open"
    assert report.headline.answer == "Not certified"
    assert len(report.motions) == 2
    assert 'id="certificate"' not in render_page(report)


def test_a_run_that_was_not_begun_has_a_page(complete: RunResults) -> None:
    """Nothing but a configuration still makes a page: machine and workspace are known."""
    bare = RunResults(complete.config, complete.machine, {}, {})
    report = build_report(bare)
    assert report.headline.answer == "Not complete"
    assert "<script" not in render_page(report)
    assert report.workspace is not None
    assert report.workspace_picture is not None
    assert base64.b64decode(report.workspace_picture.png).startswith(b"\x89PNG")


def test_a_missing_part_is_no_success(complete: RunResults) -> None:
    """A run without a way back is not reported as done: the page says what is missing, why, and what to change."""
    timing = complete.facts[Stage.RETIME]
    back = {"status": "failed", "reason": "on the way back, c2 is <too> weak", "advice": "a stronger one"}
    section = {**timing.section, "status": "done in part", "back": back}
    report = build_report(replace(complete, facts={**complete.facts, Stage.RETIME: replace(timing, section=section)}))
    assert (report.headline.answer, report.headline.mood) == ("Done in part", "bad")
    assert (report.verdicts[0].answer, report.verdicts[0].mood) == ("Exit code 1", "bad")
    row = next(row for row in report.stages if row.name == Stage.RETIME)
    assert (row.status, row.mood, row.advice) == ("done in part", "bad", "a stronger one")
    assert "On the way back, c2 is &lt;too&gt; weak" in render_page(report)
    assert len(report.motions) == 2


def test_what_prevents_a_route_is_listed(
    complete: RunResults, failed_at: Callable[[RunResults, Stage], RunResults]
) -> None:
    """The page of a run without a route has all that was found out about it, and the picture of what can be reached."""
    run = failed_at(complete, Stage.ROUTE)
    lines = ["Reach: 3 of <9>", "One change at a time:", "- more <steps>: a route exists", "- less: no route"]
    found = {**run.facts[Stage.ROUTE].section, "why_not": lines}
    facts = {**run.facts, Stage.ROUTE: StageFacts(True, found)}
    page = render_page(build_report(replace(run, facts=facts, reach=b"a picture")))
    assert "Reach: 3 of &lt;9&gt;" in page
    assert "<li>more &lt;steps&gt;: a route exists</li><li>less: no route</li>" in page
    (picture, _) = (attributes for tag, attributes in Outline(page).tags if tag == "img")
    assert picture["src"] == f"data:image/png;base64,{base64.b64encode(b'a picture').decode()}"
    assert "Reach: 3 of <9>" in str(picture["alt"])


def test_the_error_of_the_tool_is_shown_where_it_was_asked_for(complete: RunResults) -> None:
    """As a picture, with the largest bounds and samples in words."""
    assert "Error of the tool" not in render_page(build_report(complete))
    gains = DriveAmplification(np.ones((2, 5)), np.ones((2, 5)))
    errors = Uncertainty(actuator_m=(1e-4,) * 5)
    found = PoseError(errors, np.array([0.0, 0.4, 1.0]), np.array([1e-3, 2e-3]), np.array([3e-3, 1e-3]), gains)
    sampled = SampledError(np.array([0.5]), np.array([1.9e-3]), np.array([9e-4]))
    page = render_page(build_report(replace(complete, pose_error=(found, sampled))))
    assert "<h3>Error of the tool</h3>" in page
    assert "at most 2.000 mm near s = 0.70, and 3.000 mrad near s = 0.20" in page
    assert "samples are 1.900 mm" in page


@pytest.mark.parametrize("stage", [Stage.REFINE, Stage.RETIME])
def test_a_route_without_a_motion_is_shown(
    complete: RunResults, failed_at: Callable[[RunResults, Stage], RunResults], stage: Stage
) -> None:
    """A run that failed after its route shows the route, as a picture and as a table of its steps."""
    report = build_report(failed_at(complete, stage))
    assert report.route is not None
    assert report.route.picture is not None
    assert base64.b64decode(report.route.picture.png).startswith(b"\x89PNG")
    assert "LLL from step 0" in report.route.picture.alt
    assert complete.route is not None
    assert len(report.route.table.rows) == len(complete.route)
    assert [float(row[-1]) for row in report.route.table.rows] == pytest.approx(complete.route.kappa, abs=0.05)
    assert report.route.picture.alt in html.unescape(render_page(report))


def test_a_motion_needs_no_picture_of_the_route(report: Report) -> None:
    """Where there is a motion, of the route there is the table alone."""
    assert report.route is not None
    assert report.route.picture is None


def test_headings_tables_and_pictures_can_be_read_aloud(outline: Outline) -> None:
    """Headings skip no level, tables have captions and scopes, pictures and plots are described in numbers."""
    levels = [int(tag[1]) for tag, _ in outline.tags if tag in ("h1", "h2", "h3")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    tags = [tag for tag, _ in outline.tags]
    assert tags.count("caption") == tags.count("table") > 5
    assert all(attributes.get("scope") in ("col", "row") for tag, attributes in outline.tags if tag == "th")
    described = [attributes.get("alt") for tag, attributes in outline.tags if tag == "img"]
    described += [attributes["aria-label"] for _, attributes in outline.tags if attributes.get("role") == "img"]
    assert len(described) == 5
    assert all(text is not None and len(re.findall(r"\d+\.\d", text)) >= 2 for text in described)

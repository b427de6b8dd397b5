"""The command line: exit codes, messages, where output goes, and what becomes of interrupts."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
import yaml
from rich.console import Console
from typer.testing import CliRunner, Result

from pipeline.cli import app, main
from pipeline.cli.machine_report import machine_report, usable_reach
from pipeline.cli.reporter import LiveReporter, PlainReporter, make_reporter
from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.errors import NoSolutionError
from pipeline.machine import MODES, Machine
from pipeline.route import task_endpoints
from pipeline.stage import STAGES, Stage
from pipeline.summary.wording import key_figures

Call = Callable[..., Result]
ESCAPE = "\x1b"
HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


@pytest.fixture(autouse=True)
def empty_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Run every command in an empty folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def call() -> Call:
    """Call the command line in this process."""

    def invoke(*arguments: object) -> Result:
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return invoke


@pytest.fixture
def config_file(tmp_path: Path, fast_config: Config) -> Path:
    """Write a configuration, named `quick`."""
    path = tmp_path / "machine.yaml"
    path.write_text(dump_config(fast_config))
    return path


def edit(path: Path, **changes: Any) -> Path:
    """Change keys of a YAML file without asking whether they are allowed."""
    data = yaml.safe_load(path.read_text())
    for name, value in changes.items():
        *sections, key = name.split("__")
        part = data
        for section in sections:
            part = part[int(section) if section.isdecimal() else section]
        part[key] = value
    path.write_text(yaml.safe_dump(data))
    return path


def subprocess_env() -> dict[str, str]:
    """Environment for a process of its own, with few threads."""
    return {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


class TestRun:
    """The commands that run stages."""

    def test_run(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """A run writes into results/<name>, tells what it did, where it is and what to look at next."""
        result = call("run", config_file)
        assert result.exit_code == 0
        assert (tmp_path / "results" / "quick" / "trajectory.csv").exists()
        for text in ("regions", "optimal", "converged", "gap 0.00%", "results/quick/trajectory.csv", "Next:"):
            assert text in result.stdout
        assert "regions: started" in result.stderr
        assert "figures: done" in result.stderr
        assert ESCAPE not in result.output

    def test_run_without_a_way_back(
        self, call: Call, config_file: Path, stages: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        """What there is is shown, and the run ends with 1, why, and what to change."""

        def fail(*_: object) -> None:
            raise NoSolutionError("retime", "on the way back, c2 is too weak", "a stronger one")

        monkeypatch.setattr("pipeline.retime.way_back", fail)
        result = call("run", config_file)
        assert result.exit_code == 1
        assert "done in part" in " ".join(result.stdout.split())
        assert "results/quick/trajectory.csv" in result.stdout
        assert "trajectory_back.csv" not in result.stdout
        assert "Next:" not in result.stdout
        assert "on the way back, c2 is too weak" in result.stderr
        assert "What to change: a stronger one" in result.stderr
        assert (tmp_path / "results" / "quick" / "trajectory.csv").exists()

    def test_second_run(self, call: Call, config_file: Path, stages: Any) -> None:
        """What is up to date is said to be unchanged."""
        call("run", config_file)
        stages.taken()
        result = call("run", config_file)
        assert stages.calls == []
        assert "optimal, unchanged" in result.stdout
        assert "route: unchanged" in result.stderr

    @pytest.mark.parametrize(
        ("command", "expected"),
        [
            ("route", ["regions", "route"]),
            ("refine", ["regions", "route", "refine"]),
            ("certify", ["regions", "route", "refine", "certify"]),
            ("retime", ["regions", "route", "refine", "certify", "retime"]),
        ],
    )
    def test_stage_commands(
        self, call: Call, config_file: Path, stages: Any, command: str, expected: list[str]
    ) -> None:
        """The commands named after stages run up to that stage, and again only when forced."""
        result = call(command, config_file, "--out", "here")
        assert result.exit_code == 0
        assert stages.taken() == expected
        assert "Next: gantry-tau" in result.stdout
        assert "--out here" in result.stdout
        call(command, config_file, "--out", "here")
        assert stages.taken() == []
        call(command, config_file, "--out", "here", "--force")
        assert stages.calls == expected

    def test_range_options(self, call: Call, config_file: Path, stages: Any) -> None:
        """--from and --to choose the stages."""
        assert call("run", config_file, "--to", "refine").exit_code == 0
        assert stages.taken() == ["regions", "route", "refine"]
        assert call("run", config_file, "--from", "refine", "--to", "retime").exit_code == 0
        assert stages.calls == ["refine", "certify", "retime"]

    def test_verbose(self, call: Call, config_file: Path, stages: Any) -> None:
        """-v lets the solvers talk."""
        call("refine", config_file, "-v")
        call("refine", config_file, "--force", "--verbose")
        call("run", config_file, "--force")
        assert stages.verbose == [True] * 4 + [False] * 2

    def test_no_solution(self, call: Call, config_file: Path, stages: Any) -> None:
        """No solution is exit code 1 with reason, advice, and where the diagnosis is; earlier stages are kept."""
        stages.failures["route"] = NoSolutionError("route", "no route exists [proven]", "allow more tilt")
        result = call("run", config_file)
        assert result.exit_code == 1
        assert "error: route: no route exists [proven]\n  What to change: allow more tilt\n" in result.stderr
        assert "results/quick/failed/route.json" in result.stderr
        assert "Traceback" not in result.output
        assert result.stdout == ""
        assert Path("results/quick/regions.npz").exists()

    def test_interrupt(self, call: Call, config_file: Path, stages: Any) -> None:
        """Ctrl-C in a stage ends with 130 and one line; what was finished is kept."""
        stages.failures["refine"] = KeyboardInterrupt()
        result = call("run", config_file)
        assert result.exit_code == 130
        assert result.stderr.splitlines()[-1] == "interrupted: nothing is lost, finished stages are kept"
        assert Path("results/quick/route.csv").exists()
        assert not Path("results/quick/path.npz").exists()

    def test_unusable_folder(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """A folder that cannot be written to is named, with exit code 2."""
        (tmp_path / "file").touch()
        for out in ("file", "file/deeper", "/proc/none"):
            result = call("run", config_file, "--out", out)
            assert result.exit_code == 2
            assert out in result.stderr
            assert "Traceback" not in result.output

    def test_foreign_folder(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """Someone's own config.yaml is not overwritten by the resolved one."""
        mine = config_file.rename(tmp_path / "config.yaml")
        before = mine.read_bytes()
        result = call("run", mine, "--out", ".")
        assert result.exit_code == 2
        assert "is no run folder" in result.stderr
        assert mine.read_bytes() == before

    def test_rerun_from_the_results(self, call: Call, config_file: Path, stages: Any) -> None:
        """The resolved configuration in a run folder is one like any other, and gives the same results."""
        call("run", config_file)
        stages.taken()
        result = call("run", "results/quick/config.yaml")
        assert result.exit_code == 0
        assert stages.calls == []

    @pytest.mark.parametrize("name", [".", ".."])
    def test_name_that_is_no_folder(self, call: Call, config_file: Path, stages: Any, name: str) -> None:
        """A name that would write beside the results is refused."""
        result = call("run", edit(config_file, name=name))
        assert result.exit_code == 2
        assert stages.calls == []


class TestCertify:
    """The proof on the command line; the stages are fakes, and so is their certificate."""

    def test_a_refused_path_ends_the_run(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """Exit 1, the path kept, no trajectory, and a verdict that cannot be missed."""
        stages.failures["certify"] = NoSolutionError(
            "certify", "no way at s = 0.3", "widen", {"status": "not certified"}
        )
        result = call("run", config_file, "--out", tmp_path / "out")
        assert result.exit_code == 1
        assert "no way at s = 0.3" in result.stderr
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["certificate"]["verdict"] == "not certified"
        assert told["trajectory"] == {"status": "skipped"}
        assert (tmp_path / "out" / "path.npz").exists()
        assert (tmp_path / "out" / "failed" / "certify.json").exists()
        assert not (tmp_path / "out" / "certificate.json").exists()

    def test_tolerances_are_asked_for(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """They are searched, and told; the configuration stays what it is."""
        result = call("certify", config_file, "--tolerance", "--out", tmp_path / "out")
        assert result.exit_code == 0
        assert "link lengths may be wrong by 0.10 mm" in result.stdout
        assert stages.proofs == ["tolerances"]
        certificate = json.loads((tmp_path / "out" / "certificate.json").read_text())
        assert certificate["settings"]["what"] == "tolerances"
        assert load_config(tmp_path / "out" / "config.yaml").certify.what == "path"

    def test_tolerances_cost_nothing_else(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """The trajectory stays, to the byte; pictures and report, which tell of the proof, are to be made anew."""
        out = tmp_path / "out"
        call("run", config_file, "--out", out)
        before = {file: file.read_bytes() for file in out.rglob("*.*") if file.is_file()}
        stages.taken()
        call("certify", config_file, "--tolerance", "--out", out)
        assert stages.taken() == ["certify"]
        kept = {file: content for file, content in before.items() if file.exists()}
        changed = {file.name for file, content in kept.items() if file.read_bytes() != content}
        assert changed == {"certificate.json", "summary.json", "state.json"}
        assert {file.suffix for file in before.keys() - kept.keys()} == {".png", ".pdf", ".html"}
        assert not list((out / "superseded").rglob("trajectory.*"))
        call("run", config_file, "--out", out)
        assert stages.taken() == ["figures"]

    @pytest.mark.parametrize("command", ["run", "retime", "certify"])
    def test_tolerances_once_found_stay(
        self, call: Call, config_file: Path, stages: Any, tmp_path: Path, command: str
    ) -> None:
        """A certificate that proves more than is asked for is up to date."""
        out = tmp_path / "out"
        call("run", config_file, "--out", out)
        call("certify", config_file, "--tolerance", "--out", out)
        certificate = (out / "certificate.json").read_bytes()
        stages.taken()
        assert call(command, config_file, "--out", out).exit_code == 0
        assert stages.calls == (["figures"] if command == "run" else [])
        assert (out / "certificate.json").read_bytes() == certificate
        assert json.loads((out / "summary.json").read_text())["certificate"]["tolerance_m"] == 1e-4
        assert "link lengths may be wrong by 0.10 mm" in call(command, config_file, "--out", out).stdout

    def test_a_weaker_certificate_is_not_enough(
        self, call: Call, config_file: Path, stages: Any, tmp_path: Path
    ) -> None:
        """Tolerances are searched although the path is proven, a second time only where the path is another one."""
        for again in (["certify"], []):
            call("certify", config_file, "--out", tmp_path / "out")
            stages.taken()
            call("certify", config_file, "--tolerance", "--out", tmp_path / "out")
            assert stages.calls == again
        stages.taken()
        call("certify", edit(config_file, route__kappa_max=90.0), "--out", tmp_path / "out")
        assert "certify" in stages.calls
        assert stages.proofs[-1] == "path"

    def test_nothing_is_proven_where_nothing_is_asked(
        self, call: Call, config_file: Path, stages: Any, tmp_path: Path
    ) -> None:
        """The summary says so."""
        config = yaml.safe_load(config_file.read_text())
        config_file.write_text(yaml.safe_dump({**config, "certify": {"what": "nothing"}}))
        assert call("certify", config_file, "--out", tmp_path / "out").exit_code == 0
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["certificate"]["verdict"] == "skipped"
        assert "certify" not in stages.calls

    def test_a_certificate_that_does_not_hold(self, call: Call, config_file: Path, stages: Any, tmp_path: Path) -> None:
        """What was not verified is told, with exit code 1."""
        call("certify", config_file, "--out", tmp_path / "out")
        result = call("certify", "--check", tmp_path / "out" / "certificate.json")
        assert result.exit_code == 1
        assert "NO" in result.stdout
        assert "does not hold" in result.stderr

    def test_options_that_exclude_each_other(self, call: Call, config_file: Path, tmp_path: Path) -> None:
        """Verifying searches nothing, and proving needs a configuration."""
        assert call("certify").exit_code == 2
        assert call("certify", config_file, "--check", tmp_path / "certificate.json").exit_code == 2
        assert call("certify", "--check", tmp_path / "certificate.json").exit_code == 2


class TestBadInput:
    """Bad input ends with one clear message, exit code 2 and earlier results untouched."""

    @pytest.mark.parametrize(
        ("changes", "expected"),
        [
            ({"machine__rails__0__colour": "red"}, "machine.rails[0].colour"),
            ({"route__grid__y_m__stepp": 0.1}, "did you mean step"),
            ({"machine__rails__0__travel_m": [0.0, 2100]}, "millimetres"),
            ({"machine__limits__carts__velocity_mps": -0.5}, "machine.limits.carts.velocity_mps"),
            ({"machine__links__l1__length_m": -1.09}, "machine.links.l1.length_m"),
            ({"task__start__y_m": 1.9}, "task.start: is out of reach"),
            ({"task__start__x_m": 0.1}, "needs c1 at"),
            ({"task__goal__mode": "LXR"}, "task.goal.mode"),
            ({"task__goal__mode": "RRL"}, "task.goal"),
            ({"task__tilt_max_deg": "much"}, "task.tilt_max_deg"),
            ({"route__grid__z_m": {"min": 1.0, "max": 0.5, "step": 0.1}}, "the grid is empty"),
            ({"route__grid__z_m__step": 0.0}, "route.grid.z_m.step"),
            ({"retime__period_s": 10.0}, "retime.period_s"),
        ],
    )
    def test_bad_values(
        self, call: Call, config_file: Path, stages: Any, changes: dict[str, Any], expected: str
    ) -> None:
        """Every bad value is told with its key, in every command that reads it, before anything is touched."""
        bad = edit(config_file, **changes)
        for command in ("run", "check"):
            result = call(command, bad)
            assert result.exit_code == 2
            assert expected in result.stderr
            assert f"error: {bad} cannot be used" in result.stderr
            assert result.stdout == ""
        assert stages.calls == []
        assert not Path("results").exists()

    def test_earlier_results_stay(self, call: Call, config_file: Path, stages: Any) -> None:
        """A configuration that got worse costs no results."""
        call("run", config_file)
        before = {path: path.read_bytes() for path in Path("results").rglob("*") if path.is_file()}
        assert call("run", edit(config_file, task__goal__y_m=1.9), "--force").exit_code == 2
        assert {path: path.read_bytes() for path in Path("results").rglob("*") if path.is_file()} == before

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("machine: [", "is not valid YAML"),
            ("a: 1\na: 2\n", "given twice"),
            ("", "machine, task and route"),
            ("- 1\n", "machine, task and route"),
            ("name: x\n", "machine: is missing"),
        ],
    )
    def test_bad_files(self, call: Call, tmp_path: Path, text: str, expected: str) -> None:
        """Files that are no configuration at all are told what is wrong with them."""
        (tmp_path / "bad.yaml").write_text(text)
        result = call("run", "bad.yaml")
        assert result.exit_code == 2
        assert expected in result.stderr
        assert not (tmp_path / "results").exists()

    @pytest.mark.parametrize("name", ["none.yaml", "."])
    def test_no_file(self, call: Call, name: str) -> None:
        """A file that is not there is named."""
        result = call("run", name)
        assert result.exit_code == 2
        assert f"{name} cannot be used" in result.stderr

    @pytest.mark.parametrize(
        "arguments",
        [
            ["run"],
            ["run", "a.yaml", "--from", "certify"],
            ["run", "a.yaml", "--unknown"],
            ["fly", "a.yaml"],
            ["check"],
            ["compare", "x", "--markdown", "--json"],
            ["compare", "x"],
            ["export", "x", "--format", "dwg"],
            ["export", "x", "--period", "soon"],
        ],
    )
    def test_bad_usage(self, call: Call, arguments: list[str]) -> None:
        """Commands that make no sense end with 2 and say why on stderr."""
        result = call(*arguments)
        assert result.exit_code == 2
        assert result.stderr
        assert result.stdout == ""
        assert "Traceback" not in result.output

    def test_from_before_to(self, call: Call, config_file: Path, stages: Any) -> None:
        """An empty range of stages is refused."""
        result = call("run", config_file, "--from", "retime", "--to", "route")
        assert result.exit_code == 2
        assert "--from retime comes after --to route" in result.stderr


class TestCheck:
    """The machine and its task, shown."""

    def test_a_load_too_heavy_for_the_start(self, call: Call, config_file: Path) -> None:
        """It is told before anything is planned, with what can help there, and with what the machine holds."""
        result = call("check", edit(config_file, machine__dynamics__load_kg=300.0))
        assert result.exit_code == 1
        assert "c1 holds" in result.stdout
        assert "is valid" not in result.stdout
        assert "just to hold the machine at the start" in result.stderr
        assert "give the task another start" in result.stderr
        assert "kappa" not in result.stderr

    def test_reference_machine(self, call: Call, config_file: Path, fast_config: Config, machine: Machine) -> None:
        """Start and goal, grid and limits are shown with units, and nothing is written."""
        result = call("check", config_file)
        assert result.exit_code == 0
        start, _ = task_endpoints(fast_config, machine)
        for text in (
            "5 actuators, 5 degrees of freedom",
            f"{start.kappa:.3f}",
            f"{start.q_m[1]:.4f}",
            f"{17 * 15 * 7 * 7 * 8:,} candidates",
            "acceleration m/s^2",
            "0.95 to 1.25",
            "not checked",
            "is valid",
        ):
            assert text in result.stdout
        assert result.stderr == ""
        assert not Path("results").exists()

    @pytest.mark.parametrize(
        ("locked", "expected"),
        [(["rx"], "4 degrees of freedom in this task (x, y, z, rz); rx held at zero"), (["rx", "rz"], "3 degrees")],
    )
    def test_locked_axes(self, call: Call, config_file: Path, locked: list[str], expected: str) -> None:
        """Locked axes are no degrees of freedom."""
        text = " ".join(call("check", edit(config_file, task__locked_axes=locked)).stdout.split())
        assert expected in text

    def test_a_cap_below_the_ends(self, call: Call, config_file: Path) -> None:
        """A cap on the path's kappa that the start is above already is told before anything is computed."""
        result = call("check", edit(config_file, refine__kappa_max=10.0))
        assert result.exit_code == 2
        assert "refine.kappa_max" in result.stderr

    def test_rail_clearance(self, call: Call, config_file: Path) -> None:
        """A distance to rails that is asked for is shown as a limit."""
        result = call("check", edit(config_file, machine__clearance__link_rail_m=0.05))
        assert ">= 0.05" in result.stdout

    def test_schema(self, call: Call, tmp_path: Path) -> None:
        """The schema is pure JSON, names every key, and refuses unknown ones."""
        schema = json.loads(call("check", "--schema").stdout)
        sections = {"name", "machine", "task", "route", "refine", "certify", "retime", "export"}
        assert set(schema["properties"]) == sections
        assert schema["additionalProperties"] is False
        assert "$defs" in schema

    def test_reach_is_symmetric(self, machine: Machine) -> None:
        """Without tilt, all-left and all-right are mirror images but for the platform's own asymmetry in x."""
        left, right = (usable_reach(machine, MODES.index(mode), 100.0) for mode in ("LLL", "RRR"))
        assert left.z_m == right.z_m
        assert left.area_m2 == pytest.approx(right.area_m2, rel=0.1)
        assert left.y_m is not None
        assert left.y_m[0] < 0.3 < left.y_m[1]

    def test_no_reach(self, machine: Machine) -> None:
        """A machine that can be nowhere has an empty reach."""
        reach = usable_reach(machine, 0, 1.0)
        assert (reach.x_m, reach.y_m, reach.z_m, reach.area_m2) == (None, None, None, 0.0)

    def test_empty_reach_is_shown(self, fast_config: Config, machine: Machine, change: Any) -> None:
        """An empty reach reads "none"."""
        console = Console(file=StringIO(), width=110)
        ends = task_endpoints(fast_config, machine)
        for part in machine_report(change(fast_config, route__kappa_max=2.0), machine, ends):
            console.print(part)
        assert "none" in console.file.getvalue()


class TestLooks:
    """Commands that look at a run."""

    @pytest.fixture(autouse=True)
    def _run(self, call: Call, config_file: Path, stages: Any) -> None:
        call("run", config_file, "--out", "out")

    def test_compare(self, call: Call) -> None:
        """The table shows both paths."""
        result = call("compare", "out")
        assert result.exit_code == 0
        assert "kappa integral" in result.stdout
        assert "refined" in result.stdout
        assert ESCAPE not in result.output

    def test_compare_markdown(self, call: Call) -> None:
        """Markdown goes to stdout alone."""
        assert call("compare", "out", "--markdown").stdout.startswith("| figure | unit |")

    def test_compare_json(self, call: Call) -> None:
        """JSON has the figures of the summary, unrounded."""
        rows = {row["figure"]: row for row in json.loads(call("compare", "out", "--json").stdout)}
        path = json.loads(Path("out/summary.json").read_text())["path"]
        assert rows["kappa integral"]["refined"] == path["kappa_integral"]
        assert rows["kappa integral"]["coarse"] == path["coarse_kappa_integral"]

    def test_compare_in_time(self, call: Call, stages: Any) -> None:
        """Both paths are timed, unless that is not wanted or cannot be done."""
        stages.taken()
        names = [row["figure"] for row in json.loads(call("compare", "out", "--json").stdout)]
        assert "duration" in names
        assert stages.taken() == ["retime"] * 2
        names = [row["figure"] for row in json.loads(call("compare", "out", "--json", "--no-timing").stdout)]
        assert "duration" not in names
        assert stages.taken() == []
        stages.failures["retime"] = NoSolutionError("retime", "too weak", "stronger motors")
        result = call("compare", "out")
        assert result.exit_code == 0
        assert "duration" not in result.stdout
        assert "stronger motors" in result.stderr

    def test_compare_tells_what_is_not_certified(self, call: Call, config_file: Path) -> None:
        """A path without a certificate can be compared, and is said to have none; one that has is not spoken of."""
        call("refine", config_file, "--out", "other")
        result = call("compare", "out", "other", "--no-timing")
        assert result.exit_code == 0
        assert result.stderr.count("not certified") == 1
        assert "other: the refined path is not certified" in result.stderr

    def test_compare_runs(self, call: Call, config_file: Path) -> None:
        """Runs of one name are told apart by their folders; equal runs have no difference."""
        call("run", config_file, "--out", "other")
        result = call("compare", "out", "other", "out")
        assert result.exit_code == 0
        assert "against the first run" in result.stdout
        told = json.loads(call("compare", "out", "other", "--json").stdout)
        assert told["runs"] == ["out", "other"]
        assert {row["differences"][1] for row in told["rows"]} == {0.0}
        assert {"kappa integral", "duration", "working-mode changes"} <= {row["figure"] for row in told["rows"]}
        assert call("compare", "out", "other", "--markdown").stdout.startswith("| figure | unit | out | other | best |")

    def test_export_is_the_table_of_the_run(self, call: Call) -> None:
        """At the run's own period the export is trajectory.csv."""
        result = call("export", "out")
        assert result.exit_code == 0
        assert result.stdout == Path("out/trajectory.csv").read_text()

    def test_export_at_another_period(self, call: Call) -> None:
        """Another period gives other rows of the same motion, to the goal at rest."""
        from pipeline.export import read_csv

        result = call("export", "out", "--format", "csv", "--period", "0.003", "--output", "sub/t.csv")
        assert result.exit_code == 0
        assert result.stdout == ""
        assert "668 rows 0.003 s apart, 2.001 s" in result.stderr
        fine, coarse = read_csv(Path("sub/t.csv").read_text()), read_csv(Path("out/trajectory.csv").read_text())
        for name in (f"q{k}_m" for k in range(1, 6)):
            assert fine[name][-1] == pytest.approx(coarse[name][-1], abs=1e-9)
        assert all(fine[f"qd{k}_mps"][-1] == 0.0 for k in range(1, 6))

    @pytest.mark.parametrize("kind", ["ros2", "ros2-json", "linuxcnc", "beckhoff", "mujoco"])
    def test_export_in_every_format(self, call: Call, kind: str) -> None:
        """Each format is written, to a file or to stdout alike."""
        shown = call("export", "out", "--format", kind, "--period", "0.05")
        assert shown.exit_code == 0
        assert call("export", "out", "--format", kind, "--period", "0.05", "--output", "x").exit_code == 0
        assert Path("x").read_bytes() == shown.stdout_bytes

    def test_export_slower_and_backwards(self, call: Call) -> None:
        """Half the speed takes twice as long; the way back begins at the goal."""
        from pipeline.export import read_csv

        there = read_csv(call("export", "out", "--speed", "0.5").stdout)
        back = read_csv(call("export", "out", "--back").stdout)
        assert there["t_s"][-1] == pytest.approx(4.0)
        assert back["t_s"][-1] == pytest.approx(2.0)
        assert back["q1_m"][0] == there["q1_m"][-1]
        assert back["q1_m"][-1] == there["q1_m"][0]

    def test_export_with_options_of_csv(self, call: Call) -> None:
        """Separator, columns and units as asked for; what the period does not allow is refused."""
        options = ["--separator", "semicolon", "--length", "mm", "--columns", "t_s, q1_m"]
        assert call("export", "out", *options).stdout.startswith("t_s;q1_mm\n0.000000000000;")
        refused = call("export", "out", "--decimals", "3")
        assert refused.exit_code == 2
        assert "decimals are too few" in refused.stderr
        assert call("export", "out", "--speed", "1.5").exit_code == 2
        nothing = call("export", "out", "--columns", "")
        assert nothing.exit_code == 2
        assert "--columns names no column" in nothing.stderr
        slow = call("export", "out", "--speed", "0.000001")
        assert slow.exit_code == 2
        assert "retime.speed (--speed)" in slow.stderr

    def test_export_spares_the_run(self, call: Call) -> None:
        """Files of the run are not written over."""
        before = Path("out/trajectory.csv").read_bytes()
        result = call("export", "out", "--period", "0.02", "--output", "out/trajectory.csv")
        assert result.exit_code == 2
        assert Path("out/trajectory.csv").read_bytes() == before

    def test_impossible_period(self, call: Call) -> None:
        """Periods are held against what configurations allow."""
        result = call("export", "out", "--period", "7")
        assert result.exit_code == 2
        assert "retime.period_s" in result.stderr

    def test_damaged_results(self, call: Call) -> None:
        """Results edited by hand are not shown as the run's."""
        Path("out/path.npz").write_bytes(b"mine")
        result = call("compare", "out")
        assert result.exit_code == 2
        assert "path.npz" in result.stderr


class TestHelp:
    """Help texts."""

    @pytest.mark.parametrize("command", ["run", "route", "refine", "certify", "retime", "check", "compare", "export"])
    def test_examples(self, call: Call, command: str) -> None:
        """The help of every command has an example that names it."""
        result = call(command, "--help")
        assert result.exit_code == 0
        assert f"gantry-tau {command} " in result.stdout

    def test_root(self, call: Call) -> None:
        """The root help shows how to begin, and what exit codes mean."""
        result = call("--help")
        assert "gantry-tau check configs/agder.yaml" in result.stdout
        assert "Exit codes" in result.stdout

    def test_version(self, call: Call) -> None:
        """The version is that of the package."""
        from importlib.metadata import version

        assert call("--version").stdout == f"gantry-tau {version('gantry-tau')}\n"


class TestReporters:
    """Progress on terminals and elsewhere."""

    def test_choice(self) -> None:
        """Lines move on terminals only, and not when solvers write there, too."""
        terminal = Console(file=StringIO(), force_terminal=True, legacy_windows=False, _environ={"TERM": "xterm"})
        dumb = Console(file=StringIO(), force_terminal=True, _environ={"TERM": "dumb"})
        assert isinstance(make_reporter(terminal, verbose=False), LiveReporter)
        assert isinstance(make_reporter(terminal, verbose=True), PlainReporter)
        assert isinstance(make_reporter(dumb, verbose=False), PlainReporter)
        assert isinstance(make_reporter(Console(file=StringIO()), verbose=False), PlainReporter)

    def test_plain_lines_are_rare(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """A message appears when the last one is five seconds old, with the fraction where it is known."""
        now = [0.0]
        monkeypatch.setattr("pipeline.cli.reporter.time.monotonic", lambda: now[0])
        file = StringIO()
        with PlainReporter(Console(file=file, width=20)) as reporter:
            progress = reporter.begin(Stage.ROUTE)
            for second in range(12):
                now[0] = float(second)
                progress(f"route: second {second} of a rather long story", second / 10 if second > 5 else None)
            reporter.end(Stage.ROUTE, "done", 11.04)
            reporter.end(Stage.REFINE, "unchanged", 3.0)
        assert file.getvalue().splitlines() == [
            "route: started",
            "route: second 5 of a rather long story",
            "route: second 10 of a rather long story (100%)",
            "route: done (11.0 s)",
            "refine: unchanged",
        ]

    @pytest.mark.parametrize("colour", [True, False])
    def test_live_line(self, colour: bool) -> None:
        """The line shows stage, message and bar; nothing of it is left in the end but a line per stage."""
        file = StringIO()
        console = Console(
            file=file, force_terminal=True, width=100, no_color=not colour, _environ={"TERM": "xterm-256color"}
        )
        with LiveReporter(console) as reporter:
            progress = reporter.begin(Stage.ROUTE)
            progress("counting [moves]")
            progress("nearly there", 0.9)
            reporter._live.refresh()
            progress("no idea")
            reporter.end(Stage.ROUTE, "done", 1.25)
            reporter.end(Stage.REFINE, "unchanged", 1.0)
        text = file.getvalue()
        assert "nearly there" in text
        assert "route   done" in text
        assert "refine  unchanged" in text
        assert ("\x1b[32m" in text) is colour
        assert text.rindex(SHOW_CURSOR) > text.rindex(HIDE_CURSOR)

    def test_live_line_goes_away_after_errors(self) -> None:
        """The cursor comes back when a stage is interrupted."""
        file = StringIO()
        console = Console(file=file, force_terminal=True, _environ={"TERM": "xterm"})
        with pytest.raises(KeyboardInterrupt), LiveReporter(console) as reporter:
            reporter.begin(Stage.ROUTE)("working")
            raise KeyboardInterrupt
        assert file.getvalue().rindex(SHOW_CURSOR) > file.getvalue().rindex(HIDE_CURSOR)

    def test_key_figures(self) -> None:
        """Every stage can tell its figures."""
        assert key_figures(Stage.FIGURES, {"count": 4}) == "4 pictures"
        assert key_figures(Stage.REGIONS, {"count": 1234, "gates": 5}) == "1,234 regions, 5 of them gates"


class TestMain:
    """What the installed command does, in this process."""

    def test_exit(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        """The process ends with the command's exit code."""
        monkeypatch.setattr(sys, "argv", ["gantry-tau", "run", "none.yaml"])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 2
        assert "none.yaml cannot be used" in capsys.readouterr().err

    @pytest.mark.parametrize("arguments", [["check", "--schema"], ["check", "CONFIG"]])
    def test_reader_that_leaves(self, monkeypatch: pytest.MonkeyPatch, config_file: Path, arguments: list[str]) -> None:
        """Whatever was being written when the reader went, the process ends quietly."""
        read_end, write_end = os.pipe()
        os.close(read_end)
        argv = ["gantry-tau", *(str(config_file) if word == "CONFIG" else word for word in arguments)]
        with os.fdopen(write_end, "w") as stream:
            monkeypatch.setattr(sys, "argv", argv)
            monkeypatch.setattr(sys, "stdout", stream)
            with pytest.raises(SystemExit) as ended:
                main()
        assert ended.value.code == 141


class TestProcess:
    """The command line as a process of its own."""

    def start(self, *arguments: object, **options: Any) -> subprocess.Popen[str]:
        """Start `python -m pipeline`; Ctrl-C reaches it even where the tests run in the background."""
        return subprocess.Popen(
            [sys.executable, "-m", "pipeline", *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=subprocess_env(),
            preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
            **options,
        )

    def test_help_loads_no_solver(self) -> None:
        """Help appears at once: nothing that takes long to load is loaded."""
        script = (
            "import sys\nfrom typer.testing import CliRunner\nfrom pipeline.cli import app\n"
            "assert CliRunner().invoke(app, ['run', '--help']).exit_code == 0\n"
            "print([name for name in ('numpy', 'scipy', 'casadi', 'highspy', 'toppra', 'matplotlib') "
            "if name in sys.modules])"
        )
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=subprocess_env()
        )
        assert done.stdout.strip() == "[]"

    def test_reader_that_leaves(self) -> None:
        """A reader that closes the pipe early gets no traceback in return."""
        process = self.start("check", "--schema")
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.wait(60) == 141
        assert process.stderr.read() == ""
        process.stderr.close()

    def test_bad_config(self, tmp_path: Path) -> None:
        """Errors are one message on stderr and an exit code, without escape codes."""
        (tmp_path / "bad.yaml").write_text("machine: [")
        process = self.start("run", "bad.yaml", cwd=tmp_path)
        out, error = process.communicate(timeout=60)
        assert process.returncode == 2
        assert out == ""
        assert error.startswith("error: bad.yaml cannot be used:")
        assert ESCAPE not in error
        assert "Traceback" not in error

    @pytest.mark.slow
    @pytest.mark.parametrize("stage", ["regions", "route", "refine", "retime"])
    def test_interrupt(self, tmp_path: Path, quick_config: Config, stage: str) -> None:
        """Ctrl-C while solvers are at work ends within seconds, cleanly, with 130."""
        (tmp_path / "quick.yaml").write_text(dump_config(quick_config))
        process = self.start("run", "quick.yaml", "--to", "retime", cwd=tmp_path)
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith(f"{stage}: started"):
                break
        # Limiting jerk begins about a second after the stage does.
        time.sleep(2.0 if stage == "retime" else 0.1)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60)
        assert process.returncode == 130
        assert "interrupted: nothing is lost" in error
        assert "Traceback" not in error
        kept = {path.name for path in (tmp_path / "results" / "quick").iterdir()}
        # A fast machine may have found the route before it is interrupted.
        assert ("route.csv" in kept) == (stage in ("refine", "retime") or "route: done" in error)
        assert "trajectory.csv" not in kept


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the coarse configuration once, with the real stages."""
    folder = tmp_path_factory.mktemp("quick")
    config = Path(__file__).parents[2] / "configs" / "quick.yaml"
    result = CliRunner().invoke(app, ["run", str(config), "--out", str(folder)])
    assert result.exit_code == 0, result.output
    return folder


@pytest.mark.slow
class TestRealStages:
    """The real stages on the coarse grid, from the YAML file to the controller's table."""

    def test_summary(self, folder: Path) -> None:
        """The figures are those of a real reconfiguration within all limits."""
        told = json.loads((folder / "summary.json").read_text())
        assert told["regions"]["count"] > 20_000
        route, path, trajectory = told["route"], told["path"], told["trajectory"]
        assert (route["status"], route["gap"], route["mode_changes"]) == ("optimal", 0.0, 3)
        assert route["steps"] <= 25
        assert path["status"] == "converged"
        assert path["det_sign_constant"] is True
        assert path["kappa_max"] <= path["coarse_kappa_max"]
        assert path["kappa_integral"] < 0.82 * path["coarse_kappa_integral"]
        assert path["closure_residual_m"] < 1e-9
        assert path["max_tilt_deg"] <= 30.0
        assert path["min_link_distance_m"] >= 0.03
        usage = trajectory["usage"]
        assert trajectory["jerk"] == "limited"
        assert max(max(usage[name]) for name in ("velocity", "acceleration", "jerk", "force", "link_force")) <= 1.001
        assert 0.0 < trajectory["gap"] < 0.005
        assert trajectory["duration_bound_s"] < trajectory["duration_without_jerk_s"] < trajectory["duration_s"]

    def test_nothing_runs_twice(self, folder: Path) -> None:
        """The second run runs no stage and changes no file."""
        before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != ".lock"}
        result = CliRunner().invoke(app, ["run", str(folder / "config.yaml"), "--out", str(folder)])
        assert result.exit_code == 0
        assert all(f"{stage}: unchanged" in result.stderr for stage in STAGES)
        assert {path: path.read_bytes() for path in before} == before

    def test_loaded_results_are_those_made(self, folder: Path) -> None:
        """Stages three and the figures come out the same, byte for byte, from loaded results."""
        before = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".npz")}
        result = CliRunner().invoke(app, ["run", str(folder / "config.yaml"), "--out", str(folder), "--from", "retime"])
        assert result.exit_code == 0
        assert {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".npz")} == before
        assert not (folder / "superseded").exists()

    def test_compare_agrees_with_summary(self, folder: Path) -> None:
        """Measured again from the files, the paths have the same figures."""
        rows = json.loads(CliRunner().invoke(app, ["compare", str(folder), "--json"]).stdout)
        path = json.loads((folder / "summary.json").read_text())["path"]
        assert {row["figure"]: row["refined"] for row in rows}["kappa integral"] == path["kappa_integral"]

    def test_no_route(self, tmp_path: Path, quick_config: Config) -> None:
        """With too little tilt there is a proof that no route exists, and exit code 1."""
        (tmp_path / "flat.yaml").write_text(dump_config(quick_config))
        edit(tmp_path / "flat.yaml", task__tilt_max_deg=5.0)
        result = CliRunner().invoke(app, ["run", str(tmp_path / "flat.yaml"), "--out", str(tmp_path / "out")])
        assert result.exit_code == 1
        assert "no route exists" in result.stderr
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["route"]["status"] == "infeasible"
        assert told["trajectory"]["status"] == "skipped"
        assert load_config(tmp_path / "out" / "config.yaml").task.tilt_max_deg == 5.0

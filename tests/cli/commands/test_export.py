"""The trajectory of a run, exported."""

from pathlib import Path

import pytest

from pipeline.export.formats import Format
from tests.cli.calls import Call, invoke
from tests.run.fake_stages import FakeStages, proven


class TestExport:
    """The command `export`."""

    @pytest.fixture(autouse=True)
    def _run(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        call("run", config_file, "--out", "out")

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

    @pytest.mark.parametrize("kind", [*Format])
    def test_export_in_every_format(self, call: Call, kind: str) -> None:
        """Each format is written, to a file or to stdout alike."""
        if kind == "mcap":
            pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
        shown = call("export", "out", "--format", kind, "--period", "0.05")
        assert shown.exit_code == 0
        assert call("export", "out", "--format", kind, "--period", "0.05", "--output", "x").exit_code == 0
        assert Path("x").read_bytes() == shown.stdout_bytes

    def test_export_says_what_it_wrote(self, call: Call) -> None:
        """Formats that leave points out say so; a model without a motion has no rows."""
        points = call("export", "out", "--format", "cam", "--output", "x.txt").stderr
        assert "points that meet 201 rows 0.01 s apart, 2 s" in points
        assert "without a motion" in call("export", "out", "--format", "urdf", "--output", "x.urdf").stderr

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

    def test_files_beside_the_export(self, call: Call) -> None:
        """LinuxCNC's HAL file and the loops of the URDF get the export's name; neither replaces the export itself."""
        assert "x/m.txt: " in call("export", "out", "--format", "linuxcnc", "--output", "x/m.txt").stderr
        assert "loadrt streamer" in Path("x/m.hal").read_text()
        assert ", and m.yaml" in call("export", "out", "--format", "urdf", "--output", "m.urdf").stderr
        assert "closed_loop" in Path("m.yaml").read_text()
        same = call("export", "out", "--format", "linuxcnc", "--output", "only.hal")
        assert same.exit_code == 2
        assert "only.hal: give two" in same.stderr
        assert not Path("only.hal").exists()
        assert call("export", "out", "--format", "urdf", "--output", "/dev/null").exit_code == 0
        assert call("export", "out", "--format", "urdf", "--output", "out/config.urdf").exit_code == 2

    def test_trip_limits_beside_the_export(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """Where nothing is proven, the command that proves it is told; else the files have what is proven."""
        result = call("export", "out", "--format", "ros2", "--output", "m.yaml")
        assert "m.controller.yaml is not written" in result.stderr
        assert "gantry-tau certify out/config.yaml --out out --following" in result.stderr
        assert not Path("m.controller.yaml").exists()
        assert invoke("run", config_file, "--out", "out", "--force", specs=proven(stages, 2e-3)).exit_code == 0
        result = call("export", "out", "--format", "ros2", "--output", "m.yaml")
        assert ", and m.controller.yaml" in result.stderr
        assert "2 mm off the path no singularity is met, but limits may be broken" in result.stderr
        assert "trajectory: 0.00199" in Path("m.controller.yaml").read_text()
        assert call("export", "out", "--format", "linuxcnc", "--length", "mm", "--output", "m.txt").exit_code == 0
        assert "FERROR = 2.0000\n" in Path("m.ini").read_text()

    def test_export_for_a_german_spreadsheet(self, call: Call) -> None:
        """Decimal commas, names of one's own, and columns that trajectory.csv does not have."""
        options = ["--separator", "semicolon", "--decimal", "comma", "--columns", "t_s,q1_m", "--names", "Zeit,X"]
        head, first, *_ = call("export", "out", *options).stdout.splitlines()
        assert head == "Zeit;X"
        assert first.startswith("0,000000000000;")
        assert call("export", "out", "--decimal", "comma").exit_code == 2

    def test_export_of_jerk(self, call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
        """Where the motion has a jerk it is a column like others; where accelerations jump there is none."""
        assert call("export", "out", "--columns", "t_s,qddd1_mps3").exit_code == 0
        monkeypatch.setattr("pipeline.retime.result.Trajectory.jerk_jumps", True)
        result = call("export", "out", "--columns", "t_s,qddd1_mps3")
        assert result.exit_code == 2
        assert "accelerations of this motion jump" in result.stderr

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

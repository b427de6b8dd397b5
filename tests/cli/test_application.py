"""The application: help, exit codes, and interrupts."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pipeline.cli import main
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.config.file import dump_config
from tests.cli.calls import ESCAPE, Call, subprocess_env


class TestHelp:
    """Help texts."""

    @pytest.mark.parametrize(
        "command", ["init", "run", "route", "refine", "certify", "retime", "check", "compare", "export"]
    )
    def test_examples(self, call: Call, command: str) -> None:
        """The help of every command has an example that names it."""
        result = call(command, "--help")
        assert result.exit_code == 0
        assert f"gantry-tau {command} " in result.stdout
        assert "<bool>" not in result.stdout

    def test_root(self, call: Call) -> None:
        """The root help shows how to begin, and what exit codes mean."""
        result = call("--help")
        assert "gantry-tau check my-cell/my-cell.yaml" in result.stdout
        assert "Exit codes" in result.stdout
        assert "<bool>" not in result.stdout

    def test_version(self, call: Call) -> None:
        """The version is that of the package."""
        from importlib.metadata import version

        assert call("--version").stdout == f"gantry-tau {version('gantry-tau')}\n"


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
        """Help appears immediately: nothing that loads slowly is loaded."""
        script = (
            "import sys\nfrom typer.testing import CliRunner\nfrom pipeline.cli import app\n"
            "assert CliRunner().invoke(app, ['run', '--help']).exit_code == 0\n"
            "print([name for name in ('numpy', 'scipy', 'casadi', 'highspy', 'matplotlib') "
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
        refine = quick_config.refine.model_copy(
            update={"nodes": 50, "coefficients": 22, "max_meshes": 1, "check_points": 1_000}
        )
        certify = quick_config.certify.model_copy(update={"what": Proof.NOTHING})
        config = quick_config.model_copy(update={"refine": refine, "certify": certify})
        (tmp_path / "quick.yaml").write_text(dump_config(config))
        process = self.start("run", "quick.yaml", "--to", "retime", cwd=tmp_path)
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith(f"{stage}: started"):
                break
        # Limiting jerk begins about half a second after the stage does.
        time.sleep(0.6 if stage == "retime" else 0.1)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60)
        assert process.returncode == 130
        assert "interrupted: nothing is lost" in error
        assert "Traceback" not in error
        kept = {path.name for path in (tmp_path / "results" / "quick").iterdir()}
        # A fast machine may have found the route before it is interrupted.
        assert ("route.csv" in kept) == (stage in ("refine", "retime") or "route: done" in error)
        assert "trajectory.csv" not in kept

"""Run folders whose files are damaged, swapped or made up: one message that names the file, no traceback."""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.artifacts.state import read_state, state_bytes
from pipeline.config import Config
from tests.cli.bad_inputs.arrays import DAMAGES
from tests.cli.calls import invoke
from tests.run.fake_stages import FakeStages

Harm = Callable[[Path], None]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, quick_config: Config) -> Path:
    """Run fake stages once."""
    folder = tmp_path_factory.mktemp("finished") / "out"
    FakeStages().run(quick_config, folder)
    return folder


@pytest.fixture(autouse=True)
def _out(finished: Path, empty_folder: None) -> None:
    """Give each test a copy of the run."""
    shutil.copytree(finished, "out")


def _written(content: bytes) -> Harm:
    return lambda file: file.write_bytes(content) and None


def _half(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def _folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


def _pipe(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)


def _device(file: Path) -> None:
    file.unlink()
    file.symlink_to("/dev/zero")


def _loop(file: Path) -> None:
    file.unlink()
    file.symlink_to(file.name)


def _other(file: Path) -> None:
    shutil.copy(file.parent / ("route.npz" if file.name != "route.npz" else "path.npz"), file)


HARMS: dict[str, Harm] = {
    "missing": Path.unlink,
    "empty": _written(b""),
    "half": _half,
    "zeros": _written(bytes(100)),
    "brackets": _written(b"[" * 100_000),
    "not UTF-8": _written(b"\xff\xfe\x00"),
    "null": _written(b"null"),
    "numbers": _written(b'{"a": 1e400, "b": NaN, "c": ' + b"9" * 5_000 + b"}"),
    "folder": _folder,
    "pipe": _pipe,
    "device": _device,
    "loop of links": _loop,
    "file of another stage": _other,
}
"""What happens to a file."""
READ = {
    "config.yaml": ("export", "out"),
    "state.json": ("export", "out"),
    "path.npz": ("export", "out"),
    "trajectory.npz": ("export", "out"),
    "route.npz": ("report", "out"),
    "regions.npz": ("report", "out"),
    "path.csv": ("compare", "out", "--no-timing"),
    "certificate.json": ("certify", "--check", "out"),
}
"""A command that needs the file."""


@pytest.mark.parametrize(("name", "harm"), [(name, harm) for name in READ for harm in HARMS])
def test_harmed_files_are_named(name: str, harm: str) -> None:
    """Nothing waits, nothing is taken for the result, and the run is not changed."""
    HARMS[harm](Path("out") / name)
    result = invoke(*READ[name])
    assert result.exit_code == 2
    assert "out" in result.stderr
    assert name in result.stderr or name == "state.json"
    assert result.stdout == ""
    assert len(result.stderr) < 2_000


def forge(name: str, content: bytes) -> None:
    """Replace a file and its hash in the state, so that only its reader can tell."""
    (Path("out") / name).write_bytes(content)
    state = read_state(Path("out"))
    assert state is not None
    digest = hashlib.sha256(content).hexdigest()
    stages = {
        stage: record.model_copy(update={"files": {**record.files, name: digest}}) if name in record.files else record
        for stage, record in state.stages.items()
    }
    Path("out/state.json").write_bytes(state_bytes(state.model_copy(update={"stages": stages})))


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", ["path.npz", "trajectory.npz"])
def test_forged_arrays_are_named(name: str, damage: str) -> None:
    """Where the hash agrees, the reader refuses."""
    forge(name, DAMAGES[damage]((Path("out") / name).read_bytes()))
    result = invoke("export", "out")
    assert result.exit_code == 2
    assert name in result.stderr
    assert "What to change" in result.stderr
    assert result.stdout == ""


def test_a_run_of_another_configuration_is_refused() -> None:
    """Results do not belong to a configuration that was edited after the run."""
    config = Path("out/config.yaml")
    config.write_text(config.read_text(encoding="utf-8").replace("tilt_max_deg: 30.0", "tilt_max_deg: 29.0"))
    result = invoke("export", "out")
    assert result.exit_code == 2
    assert "was changed after the run" in result.stderr

"""Reading and writing configuration files, and the hash that tells them apart."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config, load_config, parse_config
from pipeline.errors import ConfigError
from tests.fuzzing import fuzz

AGDER = Path(__file__).parents[2] / "configs" / "agder.yaml"


def problem(path: Path) -> str:
    """What is wrong with a file, without the line that names it."""
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    assert caught.value.source == str(path)
    first, *rest = str(caught.value).splitlines()
    assert first == f"{path} cannot be used:"
    assert len(rest) == 1
    return rest[0].strip()


def write(folder: Path, text: str | bytes) -> Path:
    """Write a file to read back."""
    path = folder / "machine.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("machine: [1, 2\ntask: 1\n", "line 2, column 5: is not valid YAML: while parsing a flow sequence, expected "),
        ("machine:\n  a: 1\n b: 2\n", "line 3, column 2: is not valid YAML: while parsing a block mapping, expected "),
        ("machine:\n\ta: 1\n", "line 2, column 1: is not valid YAML: while scanning for the next token, found "),
        ("machine: a: b\n", "line 1, column 11: is not valid YAML: mapping values are not allowed here"),
        ("machine: *rails\n", "line 1, column 10: is not valid YAML: found undefined alias 'rails'"),
        ("a: 1\n---\nb: 2\n", "line 2, column 1: is not valid YAML: expected a single document in the stream, but "),
        ("machine: !!python/object:os.system {}\n", "line 1, column 10: is not valid YAML: could not determine a "),
        ("? [a, b]\n: 1\n", "line 1, column 3: cannot be read: a list or section cannot be a key"),
        ("machine: 1\nname: \x07\n", "line 2: has a control character, which YAML does not allow"),
        (
            "name: 2024-13-45\n",
            "line 1, column 7: cannot be read: '2024-13-45' is not a value of the type timestamp (month",
        ),
        (b"name: caf\xe9\n", "is not a UTF-8 text file"),
        ("", "(top level): must be a section with the keys machine, task and route"),
        ("- machine\n", "(top level): must be a section with the keys machine, task and route"),
    ],
)
def test_a_malformed_file_is_reported_with_its_line(tmp_path: Path, text: str | bytes, message: str):
    """YAML that cannot be read is one clear message with line and column, never a traceback."""
    assert problem(write(tmp_path, text)).startswith(message)


@pytest.mark.parametrize(
    ("text", "place", "key"),
    [
        ("name: a\nname: b\n", "line 2, column 1", "name"),
        ("machine:\n  rails:\n    - {y_m: 0, z_m: 1, y_m: 2}\n", "line 3, column 24", "y_m"),
    ],
)
def test_a_key_given_twice_is_an_error(tmp_path: Path, text: str, place: str, key: str):
    """Not silently the last one, at any depth."""
    message = f"{place}: is not valid YAML: while reading a section, the key '{key}' is given twice"
    assert problem(write(tmp_path, text)) == message


def test_anchors_and_merges_work(tmp_path: Path):
    """A section may be written once and used twice, with keys changed."""
    text = AGDER.read_text()
    text = text.replace("  start: {x_m", "  start: &start {x_m").replace(
        "  goal: {x_m: 1.02, y_m: 0.3, z_m: 0.9, mode: RRR}", "  goal: {<<: *start, mode: RRR}"
    )
    assert "<<" in text
    assert load_config(write(tmp_path, text)).task == load_config(AGDER).task


def test_merges_of_merges_are_no_doubled_keys(tmp_path: Path):
    """A key that a merged section also has is not given twice, however deep the section it comes from."""
    text = "x: {a: &base {b: 1}, n: {m: &more {<<: *base, b: 2}}}\ny: {<<: *more, b: 3}\n"
    with pytest.raises(ConfigError) as caught:
        load_config(write(tmp_path, text))
    assert not any("given twice" in issue.message for issue in caught.value.issues)


def test_numbers_may_be_written_with_an_exponent(tmp_path: Path):
    """YAML 1.1 takes 1e-1 for text; it is read as the number it is."""
    text = AGDER.read_text().replace("x_step_m: 0.1", "x_step_m: 1e-1")
    assert load_config(write(tmp_path, text)).route.x_step_m == 0.1


def test_a_missing_file_is_reported(tmp_path: Path):
    """Neither a missing file nor a folder is a configuration."""
    assert problem(tmp_path / "none.yaml") == "cannot be read: No such file or directory"
    assert problem(tmp_path) == "cannot be read: Is a directory"
    inside = tmp_path / "config.yaml"
    inside.touch()
    add = f"; add --out {tmp_path} to run stages there"
    assert problem(tmp_path) == f"cannot be read: Is a directory; the configuration in it is {inside}{add}"


@pytest.mark.parametrize(
    ("file", "name"),
    [("my machine.yaml", "my-machine"), ("robot_2.v3.yaml", "robot_2.v3"), (".hidden", "hidden"), ("--.yaml", "run")],
)
def test_the_name_defaults_to_the_files(tmp_path: Path, file: str, name: str):
    """Without a name the file gives it, with dashes for what names do not allow, so that it can be read back."""
    path = tmp_path / file
    path.write_text(AGDER.read_text().replace("name: agder\n", ""))
    config = load_config(path)
    assert config.name == name
    assert parse_config(yaml.safe_load(dump_config(config))) == config


def test_a_dumped_configuration_reads_back_the_same(tmp_path: Path, agder_config: Config):
    """Dump and load are inverse, defaults included."""
    path = write(tmp_path, dump_config(agder_config))
    assert load_config(str(path)) == agder_config
    assert "period_s" in path.read_text()


def test_the_hash_depends_on_content_alone(tmp_path: Path, agder_config: Config):
    """Comments, order, spacing, spelled-out defaults and 5 for 5.0 change nothing; a value does."""
    data = agder_config.model_dump(mode="json")
    reordered = yaml.safe_dump(data, sort_keys=True, default_flow_style=False)
    text = AGDER.read_text().replace("rx_step_deg: 5\n", "rx_step_deg: 5.0   # a comment\n")
    assert config_sha256(load_config(write(tmp_path, text))) == config_sha256(agder_config)
    assert config_sha256(load_config(write(tmp_path, reordered))) == config_sha256(agder_config)
    data["route"]["kappa_max"] = 99.0
    assert config_sha256(parse_config(data)) != config_sha256(agder_config)


def test_parts_and_plain_data_have_hashes_too(agder_config: Config):
    """A section, its plain dictionary and a dictionary in another order have one hash, of 64 hexadecimal digits."""
    route = agder_config.route
    plain = route.model_dump(mode="json")
    backwards = dict(reversed(plain.items()))
    assert config_sha256(route) == config_sha256(plain) == config_sha256(backwards)
    assert len(config_sha256(route)) == 64
    assert config_sha256(agder_config.retime) != config_sha256(route)


@fuzz(100)
@given(text=st.text(max_size=60))
def test_no_text_makes_reading_fail_otherwise(tmp_path_factory: pytest.TempPathFactory, text: str):
    """Whatever a file holds, it is a configuration error and nothing else."""
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with pytest.raises(ConfigError):
        load_config(path)

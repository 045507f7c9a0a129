"""Which sessions a pattern stands for."""

from pathlib import Path

import pytest

from pipeline.errors import ConfigError
from pipeline.fleet.sessions import find_sessions, named_sessions


def configs(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def names_and_sensors(pattern: str) -> list[tuple[str, str]]:
    return [(each.name, each.sensor) for each in find_sessions(pattern)]


def test_a_session_is_called_by_its_folder_and_is_a_sensor_of_its_own(tmp_path: Path) -> None:
    configs(tmp_path, "lot/s10/config.yaml", "lot/s2/config.yaml", "lot/s2/other.yaml")
    assert names_and_sensors(f"{tmp_path}/lot/*/config.yaml") == [("s2", "s2"), ("s10", "s10")]


@pytest.mark.parametrize(("pattern", "expected"), [
    ("{sensor}/*/config.yaml", [("a_1/x", "a_1"), ("a_1/y", "a_1"), ("b_2/x", "b_2")]),
    ("{sensor}_*/*/config.yaml", [("a_1/x", "a"), ("a_1/y", "a"), ("b_2/x", "b")]),
    ("*_{sensor}/**/config.yaml", [("a_1/x", "1"), ("a_1/y", "1"), ("b_2/x", "2")]),
    ("[!b]_?/{sensor}/*.yaml", [("a_1/x", "x"), ("a_1/y", "y")]),
    ("**/{sensor}/config.yaml", [("a_1/x", "x"), ("a_1/y", "y"), ("b_2/x", "x")]),
])
def test_the_pattern_says_which_sensor_a_session_is_of(
    tmp_path: Path, pattern: str, expected: list[tuple[str, str]]
) -> None:
    configs(tmp_path, "a_1/x/config.yaml", "a_1/y/config.yaml", "b_2/x/config.yaml")
    assert names_and_sensors(f"{tmp_path}/{pattern}") == expected


def test_configurations_beside_each_other_are_called_by_their_own_names(tmp_path: Path) -> None:
    configs(tmp_path, "one.yaml", "two.yaml")
    assert names_and_sensors(f"{tmp_path}/*.yaml") == [("one", "one"), ("two", "two")]


def test_files_that_a_shell_made_of_a_pattern_are_the_sessions_of_it(tmp_path: Path) -> None:
    configs(tmp_path, "lot/s10/config.yaml", "lot/s2/config.yaml")
    files = [str(path) for path in tmp_path.glob("lot/*/config.yaml")]
    assert named_sessions(files) == find_sessions(f"{tmp_path}/lot/*/config.yaml")
    with pytest.raises(ConfigError, match="no such file"):
        named_sessions([*files, "nothing.yaml"])


def test_two_sessions_of_one_name_are_refused(tmp_path: Path) -> None:
    configs(tmp_path, "s/config.yaml", "s.yaml")
    with pytest.raises(ConfigError, match="both would be called 's'"):
        find_sessions(f"{tmp_path}/**/*.yaml")


def test_a_pattern_without_a_file_says_what_was_expected(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no file matches .* does not exist"):
        find_sessions(f"{tmp_path}/nothing/*/config.yaml")

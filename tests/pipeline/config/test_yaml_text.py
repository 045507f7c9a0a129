"""The text of a configuration: only a YAML mapping is read, and every value keeps its place."""

from pathlib import Path

import pytest

from pipeline.config.yaml_text import YamlSource, parse_source, read_source
from pipeline.errors import ConfigError


def read(folder: Path, text: str) -> YamlSource:
    path = folder / "config.yaml"
    path.write_text(text, encoding="utf-8")
    return read_source(path)


@pytest.mark.parametrize(("text", "says"), [
    ("", "the file is empty"),
    ("- a\n- b", "a list at the top level"),
    ("just words", "the text 'just words' at the top level"),
    ("time_s,acc_x\n" + 60 * "1,2\n", r"1,2\.\.\.' at the top level.*`pipeline import LOG`"),
    ("a: &x [1]\nb: [*x, *x]", "anchors"),
    ("a: !!python/object/apply:os.system [ls]", "the tag"),
    ("title: a\n---\ntitle: b", "a second document"),
    ("a:\n\tb: 1", "config.yaml:2: .*a tab"),
    ("a: [1, 2\nb: 3", "config.yaml:2: .*bracket"),
    ('a: "x', "quote"),
    ("poses: *.csv", "must be quoted"),
    ("[" * 3000, "nested deeper"),
    ("a: b: c", "colon"),
    ("a: \x07", "cannot stand in a YAML file"),
    ("x" * 300_000, "larger than 200 kB"),
])
def test_text_that_is_no_configuration_is_refused_in_one_paragraph(
    tmp_path: Path, text: str, says: str
) -> None:
    with pytest.raises(ConfigError, match=says) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_a_yaml_bomb_is_refused_before_anything_of_it_expands(tmp_path: Path) -> None:
    bomb = "a: &a [x, x]\n" + "".join(
        f"{b}: &{b} [*{a}, *{a}, *{a}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    with pytest.raises(ConfigError, match=r"config.yaml:1: anchors"):
        read(tmp_path, bomb)


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_bytes(b"title: x\nsensor: \xff\n")
    with pytest.raises(ConfigError, match=r"config.yaml:2: byte 0xff"):
        read_source(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_source(tmp_path / "absent.yaml")


def test_yaml_1_1_traps_read_as_people_mean_them() -> None:
    source = parse_source(Path("c.yaml"), "a: 1e-3\nb: no\nc: 12:30:00\nd: 010\n33: '1'\ne: ~\n")
    assert source.values == {"a": 0.001, "b": "no", "c": "12:30:00", "d": 10, "33": "1", "e": None}


def test_spans_allow_a_value_to_be_replaced_with_comments_kept() -> None:
    text = ("a:\n  model: [bias, scale ]  # terms\n  list:\n    - one   # first\n    - 'two'\n"
            "\nb: 1\n")
    source = parse_source(Path("c.yaml"), text)

    def at(*path: str | int) -> str:
        span = source.span(path)
        return text[span.start : span.end]

    assert at("a", "model") == "[bias, scale ]"
    assert at("a", "model", 1) == "scale"
    assert at("a", "list") == "- one   # first\n    - 'two'"
    assert at("a", "list", 1) == "'two'"
    assert source.span(("a", "model")).flow
    assert not source.span(("a", "list")).flow
    assert source.line(("a", "list", 1)) == 5
    assert source.line(("a", "absent")) == 1

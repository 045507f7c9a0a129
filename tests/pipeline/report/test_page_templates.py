"""Templates are compiled once and kept as Python keeps the bytecode of its modules."""

import sys
from importlib.util import cache_from_source
from pathlib import Path

import pytest
from jinja2 import Environment

import pipeline.report.page_templates as module
from pipeline.report.page_templates import page_templates

NAME = "poses.css"


@pytest.fixture
def bytecode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of all bytecode that is written from here on."""
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    Path(cache_from_source(module.__file__)).parent.mkdir(parents=True)  # as its import makes it
    return tmp_path


def rendered(monkeypatch: pytest.MonkeyPatch) -> tuple[str, int]:
    """A page's style in a new environment, and how many templates were compiled for it."""
    compiled: list[str] = []
    real = Environment.compile

    def counted(self: Environment, source: str, name: str, *rest: object) -> object:
        compiled.append(name)
        return real(self, source, name, *rest)  # type: ignore[call-overload]

    with monkeypatch.context() as patched:
        patched.setattr(Environment, "compile", counted)
        text = page_templates.__wrapped__().get_template(NAME).render()
    return text, len(compiled)


def files_in(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_a_template_is_compiled_by_the_first_run_only(
    bytecode: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = rendered(monkeypatch)
    assert first[1] == 1
    assert rendered(monkeypatch) == (first[0], 0)


@pytest.mark.parametrize("length", [0, 12, 40, 200])
def test_bytecode_that_is_not_whole_is_made_anew(
    bytecode: Path, monkeypatch: pytest.MonkeyPatch, length: int
) -> None:
    text, _ = rendered(monkeypatch)
    (file,) = files_in(bytecode)
    file.write_bytes(file.read_bytes()[:length])
    assert rendered(monkeypatch) == (text, 1)
    assert rendered(monkeypatch) == (text, 0)


def test_where_python_writes_no_bytecode_none_is_written(
    bytecode: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert rendered(monkeypatch)[1] == 1
    assert files_in(bytecode) == []


def test_a_folder_that_refuses_bytecode_is_no_error(
    bytecode: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (bytecode / "file").write_text("no folder")
    monkeypatch.setattr(sys, "pycache_prefix", str(bytecode / "file"))
    assert rendered(monkeypatch)[1] == 1

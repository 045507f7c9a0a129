"""A folder of sessions, and logs that are brought: kept inside, guessed, used, never executed."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest

from pipeline.errors import PipelineError
from pipeline.workbench.dropped import checked_name
from tests.paths import DATA
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import Browser
from tests.pipeline.workbench.asked import GIGABYTE, Asked
from tests.pipeline.workbench.conftest import Opened, opened_workbench
from tests.sessions import results_in

LOGS = sorted((DATA / "example/accelerometer").glob("*.csv*"))


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    with opened_workbench(tmp_path_factory.mktemp("lab")) as opened:
        yield opened


@pytest.fixture
def started(served: Opened) -> Iterator[Opened]:
    """The page of a folder that is empty again after each test."""
    yield served
    Asked(served).post("/forget", {})
    for path in served.config.iterdir():
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def brought(asked: Asked, name: str, content: bytes, **headers: str) -> int:
    """Status of a file that is dropped."""
    return asked.ask(f"/bring/{quote(name)}", "POST", content, Cookie=asked.cookie,
                     Origin=f"http://{asked.host}", **headers)[0]


def test_logs_are_brought_guessed_used_and_opened(started: Opened) -> None:
    asked, folder = Asked(started), started.config
    for path in LOGS:
        assert brought(asked, f"rest/{path.name}", path.read_bytes()) == 200
    status, guess = asked.post("/guess", {"scale": None})
    assert status == 200
    words = "\n".join(map(str, guess["lines"]))  # type: ignore[call-overload]
    assert "rest/pose_01" in words
    assert "first rows:" in words
    assert ".brought" not in words
    assert [plot["triad"] for plot in guess["plots"]][:1] == ["accelerometer"]  # type: ignore
    status, used = asked.post("/use", {"name": "evening", "latitude": 40.85, "height": 20})
    assert (status, used["fault"]) == (200, None)
    assert (folder / "evening/rest" / LOGS[0].name).read_bytes() == LOGS[0].read_bytes()
    assert [path.name for path in folder.iterdir()] == ["evening"]  # nothing hidden is left
    status, opened = asked.post("/open", {"number": used["number"]})
    assert opened["address"] == f"/session/{used['number']}/"
    body = asked.ask(str(opened["address"]), Cookie=asked.cookie)[2]
    assert b"bench-bar" in body
    state = {"triads": {"accelerometer": {"ticked": [], "out": []}}, "terms": {}}
    status, refit = asked.post(f"{opened['address']}refit",
                               {"triad": "accelerometer", "state": state})
    assert status == 200, refit
    assert len(refit["residual"]) == results_in(  # type: ignore[arg-type]
        folder / "evening/config.run")["accelerometer"]["n_poses"]
    assert asked.post("/use", {"name": "evening", "latitude": None})[0] == 422


def test_no_name_leads_out_of_the_folder_or_to_a_program(started: Opened) -> None:
    asked = Asked(started)
    for name in ("../evil.csv", "/etc/evil.csv", "a/../../evil.csv", ".hidden.csv", "x" * 200,
                 "a/b/c/d/e.csv", "run.py", "evil.sh", "config.yaml", "a\\b.csv", "con\x00.csv",
                 "a:b.csv"):
        assert brought(asked, name, b"time_s,acc_x\n") in (404, 422), name
    assert [path for path in started.config.rglob("*") if path.is_file()] == []
    assert [path.name for path in started.config.parent.glob("evil*")] == []


def test_a_name_has_plain_parts() -> None:
    assert checked_name("turn/pose 1 (ü).csv") == Path("turn/pose 1 (ü).csv")
    for name in ("", ".", "..", "a/../b", "a/./.b"):
        with pytest.raises(PipelineError, match="no name"):
            checked_name(name)


def test_a_file_is_bounded_and_kept_whole_or_not_at_all(started: Opened) -> None:
    asked = Asked(started)
    assert brought(asked, "big.csv", b"", Content_Length=str(2 * GIGABYTE)) == 413
    assert brought(asked, "a.csv", b"1,2,3\n") == 200
    assert brought(asked, "a.csv", b"4,5,6\n") == 422  # is there already
    assert brought(asked, "a.csv/b.csv", b"4,5,6\n") == 422  # no folder
    assert asked.ask("/bring/b.csv", "POST", b"1", Cookie=asked.cookie)[0] == 403  # no origin
    assert brought(asked, "clip.mp4", b"no clip") == 200
    status, answer = asked.post("/guess", {})
    assert status == 422
    assert str(answer["error"]).startswith("clip.mp4: no video stream")
    assert asked.post("/forget", {})[0] == 200
    assert brought(asked, "a.csv", b"1,2,3\n") == 200
    status, answer = asked.post("/guess", {})
    assert status == 422
    assert str(answer["error"]).startswith("a.csv: ")
    for name in ("../up", "/tmp/up", ".up", "", "a/b"):
        assert asked.post("/use", {"name": name})[0] == 422


def test_links_that_leave_the_folder_are_no_sessions(started: Opened, tmp_path: Path) -> None:
    asked, folder = Asked(started), started.config
    secret = tmp_path / "secret.yaml"
    secret.write_text("sensor: {name: secret}\n", encoding="utf-8")
    (folder / "link.yaml").symlink_to(secret)
    (folder / "far").symlink_to(tmp_path)
    (folder / "round.yaml").symlink_to(folder / "round.yaml")
    (folder / "notes.yaml").write_text("shopping: [bread]\n", encoding="utf-8")
    (folder / "torn.yaml").write_text("sensor: {name: [\n", encoding="utf-8")
    shutil.copytree(DATA / "example", folder / "example")
    assert asked.ask("/favicon.ico", Cookie=asked.cookie)[0] == 204
    status, _, body = asked.ask("/sessions", Cookie=asked.cookie)
    assert status == 200
    assert b"secret" not in body
    assert body.count(b'"number"') == 2
    assert b"line 2: this is not YAML" in body  # what is wrong with the other one
    assert b"example/config.yaml" in body
    for number in (-1, 7, "0", None):
        assert asked.post("/open", {"number": number})[0] == 422


@needs_browser
def test_a_person_drops_logs_and_uses_them_by_the_keyboard(
    started: Opened, browser: Browser
) -> None:
    with browser.tab() as tab:
        tab.visit(started.address)
        tab.wait("document.querySelector('[data-sessions-words]').textContent.includes('none yet')")
        texts = {path.name.removesuffix(".gz"): _text(path) for path in LOGS}
        tab.evaluate(f"""
            const data = new DataTransfer();
            for (const name of ['.DS_Store', 'config.yaml']) data.items.add(new File(['x'], name));
            for (const [name, text] of Object.entries({texts!r}))
                data.items.add(new File([text], name));
            document.querySelector('[data-drop]').dispatchEvent(
                new DragEvent('drop', {{dataTransfer: data, bubbles: true}})); return true;""")
        tab.wait("document.querySelectorAll('[data-plots] path.x').length > 0")
        words = tab.evaluate("return document.querySelector('[data-brought]').textContent")
        assert words.startswith("18 files. '.DS_Store' is no name of a file of a session. config.y")
        tab.evaluate("document.querySelector('form[data-use] [name=latitude]').focus()")
        tab.send("Input.insertText", text="40.85")
        tab.key("Enter")
        tab.wait("location.pathname.startsWith('/session/') && "
                 "!!document.querySelector('[data-bench-folder]:not([hidden])')")
        tab.click("[data-bench-folder]")  # and back
        tab.wait("location.pathname === '/' && !!document.querySelector('.sessions tr')")
        assert tab.errors == []


@needs_browser
def test_the_list_shows_what_a_terminal_writes(started: Opened, browser: Browser) -> None:
    with browser.tab() as tab:
        tab.visit(started.address)
        words = "document.querySelector('[data-sessions-words]').textContent"
        rows = "document.querySelectorAll('[data-sessions] tr').length"
        tab.wait(f"{words}.includes('none yet')")
        shutil.copytree(DATA / "example", started.config / "example")
        tab.wait(f"{rows} === 1 && {words} === ''")
        shutil.rmtree(started.config / "example")
        tab.wait(f"{rows} === 0 && {words}.includes('none yet')")
        assert tab.errors == []


def _text(path: Path) -> str:
    import gzip

    content = path.read_bytes()
    return (gzip.decompress(content) if path.suffix == ".gz" else content).decode()

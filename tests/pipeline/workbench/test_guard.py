"""The workbench answers its own page alone: each way round it is tried."""

import asyncio
import http.client
import json
import signal
import socket
import time
from pathlib import Path

import pytest

from pipeline.served.guard import LARGEST_QUESTION, LOOPBACK, POLICY
from pipeline.served.serve import beside, listening_socket
from tests.pipeline.workbench.asked import GIGABYTE, Asked
from tests.pipeline.workbench.conftest import Opened, copied, opened_workbench
from tests.sessions import pipeline


@pytest.fixture(scope="module")
def asked(opened: Opened) -> Asked:
    return Asked(opened)


def state(ticked: list[str], out: list[str]) -> dict[str, object]:
    return {"triads": {"accelerometer": {"ticked": [], "out": []},
                       "gyroscope": {"ticked": ticked, "out": out}}, "terms": {}}


def test_the_token_stands_in_the_address_once_and_then_in_a_cookie(asked: Asked) -> None:
    status, headers, _ = asked.ask(f"/?token={asked.token}")
    assert (status, headers["location"]) == (303, "/")
    for part in (asked.token, "HttpOnly", "SameSite=strict"):
        assert part in headers["set-cookie"]
    status, headers, body = asked.ask("/", Cookie=asked.cookie)
    assert (status, headers["content-security-policy"]) == (200, POLICY)
    assert "unsafe-inline" not in POLICY.partition("script-src")[2].partition(";")[0]
    assert headers["referrer-policy"] == "no-referrer"
    assert asked.token.encode() not in body


@pytest.mark.parametrize("path", ["/", "/report.js", "/columns/gyroscope", "/events", "/clip/0/0"])
def test_without_the_token_nothing_is_answered(asked: Asked, path: str) -> None:
    for cookie in ("", f"{asked.cookie[:-1]}", "pipeline-workbench=x"):
        assert asked.ask(path, Cookie=cookie)[0] == 403
    assert asked.ask(f"{path}?token=wrong")[0] == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1", "[::1]:{}", "evil.example:{}"])
def test_another_host_name_is_refused(asked: Asked, host: str) -> None:
    assert asked.ask("/", Host=host.format(asked.port), Cookie=asked.cookie)[0] == 403


@pytest.mark.parametrize("headers", [
    {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec_Fetch_Site": "cross-site"}])
@pytest.mark.parametrize("path", ["/", "/events"])
def test_another_origin_is_refused(asked: Asked, path: str, headers: dict[str, str]) -> None:
    assert asked.ask(path, Cookie=asked.cookie, **headers)[0] == 403


def test_a_question_without_an_origin_is_refused(asked: Asked) -> None:
    body = json.dumps({"triad": "gyroscope", "state": state([], [])}).encode()
    assert asked.ask("/refit", "POST", body, Cookie=asked.cookie)[0] == 403


@pytest.mark.parametrize("path", [
    "/../../etc/passwd", "/%2e%2e/config.yaml", "/config.yaml", "/results.json",
    "/columns/../../config.yaml", "/columns/%2e%2e%2fconfig.yaml", "//etc/passwd"])
def test_no_path_leads_to_a_file(asked: Asked, path: str) -> None:
    status, _, body = asked.ask(path, Cookie=asked.cookie)
    assert status in (404, 422)
    assert b"bias" not in body
    assert b"root:" not in body


def test_two_gigabytes_are_not_read(asked: Asked) -> None:
    headers = {"Cookie": asked.cookie, "Origin": f"http://{asked.host}"}
    assert asked.ask("/refit", "POST", Content_Length=str(2 * GIGABYTE), **headers)[0] == 413
    with socket.create_connection((LOOPBACK, asked.port), 30) as sent:
        head = "".join(f"{k}: {v}\r\n" for k, v in headers.items())
        sent.sendall(f"POST /refit HTTP/1.1\r\nHost: {asked.host}\r\n{head}"
                     "Transfer-Encoding: chunked\r\n\r\n".encode())
        chunk = b"%x\r\n" % LARGEST_QUESTION + b"x" * LARGEST_QUESTION + b"\r\n"
        try:
            for _ in range(50):
                sent.sendall(chunk)
        except OSError:
            return  # it has closed the connection
        assert b" 413 " in sent.recv(1000)


def test_a_name_that_is_a_script_is_no_effect(asked: Asked) -> None:
    evil = "</script><script>alert(1)</script>"
    status, answer = asked.post("/refit", {"triad": "gyroscope", "state": state([evil], [])})
    assert status == 422
    assert "no effect is named" in str(answer["error"])
    before = asked.post("/refit", {"triad": "gyroscope", "state": state([], [])})
    status, answer = asked.post("/write", {"state": state(["bias: {a: 1}\nx"], [])})
    assert status == 422
    assert asked.post("/refit", {"triad": "gyroscope", "state": state([], [])}) == before


def test_an_effect_of_ones_own_that_is_no_mapping_is_answered_with_a_sentence(asked: Asked) -> None:
    status, answer = asked.post("/write", {"state": state([], []), "own": 3})
    assert status == 422
    assert "has a name and a formula" in str(answer["error"])


@pytest.mark.parametrize("question", [
    [], "x", {"triad": "magnetometer", "state": {}}, {"triad": "gyroscope", "state": []},
    {"triad": "gyroscope", "state": {"triads": {"gyroscope": {"ticked": "x", "out": ["y"]}}}},
    {"triad": "gyroscope", "state": state([], []), "guesses": "x"},
    {"triad": "gyroscope", "state": state([], ["pose_99"])}])
def test_what_is_no_question_is_answered_with_a_sentence(asked: Asked, question: object) -> None:
    status, answer = asked.post("/refit", question)
    assert status == 422
    assert len(str(answer["error"])) > 20


def test_a_guess_of_the_page_is_added_by_a_command_that_overrules(asked: Asked) -> None:
    for guesses, ends in (([], "g_sensitivity"), (["g_sensitivity"], "--anyway")):
        status, answer = asked.post("/refit", {
            "triad": "gyroscope", "state": state(["g_sensitivity"], []), "guesses": guesses})
        assert status == 200
        (command,) = answer["commands"]  # type: ignore[misc]
        assert str(command).endswith(ends)


def test_a_report_that_is_a_link_out_of_the_folder_is_not_served(
    opened: Opened, asked: Asked, tmp_path: Path
) -> None:
    report = opened.config.with_suffix(".run") / "report.html"
    secret = tmp_path / "secret.html"
    secret.write_text("a secret", encoding="utf-8")
    kept = report.rename(report.with_name("kept.html"))
    try:
        report.symlink_to(secret)
        status, _, body = asked.ask("/", Cookie=asked.cookie)
        assert status == 404
        assert b"a secret" not in body
    finally:
        kept.replace(report)


def test_it_listens_on_the_loopback_address_alone(asked: Asked) -> None:
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("::1", asked.port), 5)
    with listening_socket(asked.port) as other:  # busy: another one is taken
        assert other.getsockname()[0] == LOOPBACK
        assert other.getsockname()[1] != asked.port


def test_what_is_still_computed_holds_up_no_end() -> None:
    begun = time.monotonic()
    with pytest.raises(TimeoutError):
        asyncio.run(asyncio.wait_for(beside(lambda: time.sleep(60)), 0.1))
    assert time.monotonic() - begun < 10


def test_ctrl_c_ends_it_at_once_and_python_runs_only_if_allowed(
    written: Path, tmp_path: Path
) -> None:
    config = copied(written, tmp_path)
    with opened_workbench(config) as opened:
        asked = Asked(opened)
        flag = tmp_path / "ran"
        (tmp_path / "own.py").write_text(
            f"from pathlib import Path\nPath({str(flag)!r}).touch()\n"
            "def own(at):\n    return at.time_s\n", encoding="utf-8")
        text = config.read_text(encoding="utf-8")
        config.write_text(f"{text}\neffects:\n  mine: {{python: own.py:own, per: axis, "
                          "unit: rad/s/s, triad: gyroscope}\n", encoding="utf-8")
        question = {"triad": "gyroscope", "state": state([], [])}
        status, answer = asked.post("/refit", question)
        assert status == 422
        assert "changed after the last run" in str(answer["error"])
        assert not flag.exists()
        assert pipeline("run", config, "--allow-python") == 0
        flag.unlink()
        status, answer = asked.post("/refit", question)
        assert status == 422
        assert "--allow-python" in str(answer["error"])
        assert not flag.exists()
        listening = http.client.HTTPConnection(LOOPBACK, asked.port, timeout=240)
        listening.request("GET", "/events", headers={"Host": asked.host, "Cookie": asked.cookie})
        news = listening.getresponse()
        assert news.status == 200  # a page that waits for news
        opened.process.send_signal(signal.SIGINT)
        assert opened.process.wait(240) == 130
        news.close()
        listening.close()

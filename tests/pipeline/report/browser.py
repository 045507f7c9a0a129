"""A page opened in headless Chromium, and what a script says in it."""

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next((p for p in map(shutil.which, ("chromium", "chromium-browser")) if p), None)
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium here to open the report in")

QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars", "--virtual-time-budget=5000",
)  # fmt: skip


def ask(page: str, folder: Path, script: str, fragment: str = "", *options: str) -> Any:
    """What ``script`` returns in the opened page."""
    assert CHROMIUM is not None
    asking = (
        "<script>window.addEventListener('load', () => { const answer = (() => {"
        + script
        + "})(); const pre = document.createElement('pre'); pre.id = 'answer';"
        "pre.textContent = JSON.stringify(answer); document.body.append(pre); });</script></body>"
    )
    path = folder / "asked.html"
    path.write_text(page.replace("</body>", asking), encoding="utf-8")
    profile = folder / "profile"
    said = subprocess.run(
        [CHROMIUM, *QUIET, *options, f"--user-data-dir={profile}", "--dump-dom",
         f"{path.as_uri()}{fragment}"],
        capture_output=True, text=True, timeout=120, check=True,
    ).stdout  # fmt: skip
    shutil.rmtree(profile, ignore_errors=True)
    answer = re.search(r'<pre id="answer">(.*?)</pre>', said, re.DOTALL)
    assert answer, "the page's own script failed"
    return json.loads(html.unescape(answer[1]))

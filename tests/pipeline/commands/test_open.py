"""The workbench in the browser: a program of the system opens its address, which is printed."""

import os
import sys
import time
from pathlib import Path

import pytest

from tests.pipeline.workbench.conftest import opened_workbench
from tests.sessions import accelerometer_alone

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="pages are opened by xdg-open on Linux")


@LINUX
def test_the_address_is_printed_and_opened_where_a_browser_is(tmp_path: Path) -> None:
    opener = tmp_path / "bin" / "xdg-open"
    opener.parent.mkdir()
    opener.write_text(f'#!/bin/sh\necho "$1" > {tmp_path}/given\n')
    opener.chmod(0o755)
    config = accelerometer_alone(tmp_path / "session")
    with opened_workbench(
        config, "--output", str(tmp_path / "out"), path=f"{opener.parent}{os.pathsep}/bin"
    ) as opened:
        assert opened.address.startswith("http://127.0.0.1:")
        for _ in range(100):
            if (tmp_path / "given").exists():
                break
            time.sleep(0.1)
        assert (tmp_path / "given").read_text().strip() == opened.address
        assert (tmp_path / "out" / "report.html").exists()

"""The same tests on every machine and every day."""

import os
import signal

import pytest
from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.load_profile("same")

# As `pipeline` itself does: the matrices are small, and the threads of OpenBLAS wait for each other
# on the cores of the other test processes. It is read when NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell has its background jobs ignore Ctrl-C, and what they start inherits that; there are tests
# that interrupt what they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """First the longest, which is mypy, and recordings: others work while these wait for devices
    played in real time."""
    items.sort(key=lambda item: not item.nodeid.startswith((
        "tests/test_static.py::test_the_tree_is_clean", "tests/pipeline/record/",
        "tests/pipeline/workbench/test_recording_page")))


@pytest.fixture
def bare_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs whose page has nothing on it, for tests that do not look at it: half of their time."""
    from pipeline.results.names import REPORT_MARK  # not before the variables above

    monkeypatch.setattr("pipeline.report.page.report_html", lambda *_: REPORT_MARK)

"""The linear algebra of a diagnosis runs on one thread, that of its caller as before."""

from typing import Any
from unittest import mock

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from calib.assess import assess
from calib.diagnosis.diagnose import diagnose


class Reached(Exception):
    """A function was called with so many threads."""


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info()
            if library["user_api"] == "blas"}


def reached(*_: Any, **__: Any) -> None:
    raise Reached(threads())


@pytest.mark.parametrize(("function", "calls"), [
    (lambda: assess(mock.ANY, mock.ANY, mock.ANY), "calib.assess.calibrate"),
    (lambda: diagnose(mock.ANY), "calib.diagnosis.diagnose.find"),
])
def test_one_thread_works_for_a_notebook_and_two_again_after_it(function: Any, calls: str) -> None:
    with threadpool_limits(limits=2, user_api="blas"):
        assert threads() == {2}
        with mock.patch(calls, reached), pytest.raises(Reached) as raised:
            function()
        assert raised.value.args == ({1},)
        assert threads() == {2}

"""The linear algebra on one thread: with matrices as small as here, threads wait for each other.

On two cores a diagnosis takes three times as long with two threads. The command forbids them from
its start; a notebook has loaded NumPy by then.
"""

from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """``function`` with the linear algebra of NumPy and SciPy on one thread while it runs."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _libraries() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401  # one that is loaded later is not limited

    return ThreadpoolController()

"""Another value in the place of a threshold for a while, in every module that has it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, TypeVar

from tests.source_tree import FILES, PACKAGES, imports, tree_of
from tests.thresholds import Threshold

T = TypeVar("T")
FACTORS = (0.5, 2.0)


def holders(path: str, name: str) -> list[str]:
    """The modules that have a constant: its own, and those that import it."""
    return [path, *(each for each in FILES if (path, name) in imports(tree_of(each)))]


@contextmanager
def changed(path: str, name: str, new: Any) -> Iterator[None]:
    """Another value of a constant, in every module that has it."""
    modules = [import_module(each) for each in holders(path, name)]
    value = getattr(modules[0], name)
    try:
        for each in modules:
            setattr(each, name, new)
        forget()
        yield
    finally:
        for each in modules:
            setattr(each, name, value)
        forget()


def forget() -> None:
    """Empty all caches of the product, and of what the tests make with it."""
    for path, module in list(sys.modules.items()):
        if path.split(".")[0] in (*PACKAGES, "tests"):
            for value in list(vars(module).values()):
                if hasattr(value, "cache_clear"):
                    value.cache_clear()


def multiplied(value: Any, factor: float) -> Any:
    """A number, or each number of several, times ``factor``; whole where it was an integer."""
    if isinstance(value, dict):
        return {key: multiplied(each, factor) for key, each in value.items()}
    if isinstance(value, tuple):
        return tuple(multiplied(each, factor) for each in value)
    return type(value)(value * factor)


def with_factors(package: str, one: Threshold, measure: Callable[[], T]) -> list[T | None]:
    """What is measured with a half and with twice of a threshold; None where it cannot be that."""
    module, _, name = f"{package}.{one.path}".rpartition(".")
    results: list[T | None] = []
    for factor in FACTORS:
        results.append(None)
        with (
            changed(module, name, multiplied(one.value, factor)),
            suppress(ValueError),  # a quantile of 1.5
        ):
            results[-1] = measure()
    return results

"""Another value in the place of a threshold for a while, in every module that has it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from tests.source_tree import FILES, PACKAGES, imports, tree_of

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


@contextmanager
def replaced(record: Any, new: Any) -> Iterator[None]:
    """Every module of ``calib`` that holds the record holds the new one meanwhile."""
    holding = [
        (module, name)
        for path, module in list(sys.modules.items()) if path.startswith("calib.")
        for name, value in vars(module).items() if value is record
    ]
    for module, name in holding:
        setattr(module, name, new)
    try:
        yield
    finally:
        for module, name in holding:
            setattr(module, name, record)

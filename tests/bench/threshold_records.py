"""The records of thresholds of a package: find them, and put another value into one for a while."""

import dataclasses
import importlib
import pkgutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

FACTORS = (0.5, 2.0)


def records_of(package: str) -> list[Any]:
    """The records of thresholds in the modules of a package, in the order of the modules."""
    folder = importlib.import_module(package)
    records: list[Any] = []
    for info in pkgutil.iter_modules(folder.__path__, f"{package}."):
        for value in vars(importlib.import_module(info.name)).values():
            if (dataclasses.is_dataclass(value) and not isinstance(value, type)
                    and type(value).__name__.endswith("Thresholds")
                    and type(value).__module__.startswith(package)
                    and not any(value is each for each in records)):
                records.append(value)
    return records


@contextmanager
def replaced(record: Any, new: Any) -> Iterator[None]:
    """Every module of the product that holds the record holds the new one meanwhile."""
    holders = [
        (module, name)
        for path, module in list(sys.modules.items()) if path.startswith(("vision.", "calib."))
        for name, value in vars(module).items() if value is record
    ]
    for module, name in holders:
        setattr(module, name, new)
    try:
        yield
    finally:
        for module, name in holders:
            setattr(module, name, record)

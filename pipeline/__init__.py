"""The program: from a configuration to a calibration, a diagnosis and a report.

The way of the data
-------------------
::

    config.yaml ─ config ─┐           ┌─ results, session_folder ─ results.json, history
    clips, logs ─ logs ───┴─ stages ──┼─ console, report ─ what a person reads
    sensor ─ devices ─ record ─ logs  └─ export ─ calibrated logs, other programs' files
    plan: expected results of poses;  model_change: add and remove
    guess: a configuration for logs of unknown tools;  text: how people read names and numbers
    fleet: a run for each of many sessions, one table, statistics of a lot
    commands, cli: the command line

``stages`` holds the five steps of a run (:mod:`pipeline.stages.run`); each calls :mod:`vision` or
:mod:`calib` and hands on its result. Files, YAML, units of people and the screen exist only here.
"""

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from pipeline.notebook import LoadedSession, load

__all__ = ["LoadedSession", "load"]


def __dir__() -> list[str]:
    """Names for completion in a notebook."""
    return list(__all__)


def __getattr__(name: str) -> Any:
    """Load a name when a notebook first uses it: the command line imports this package too."""
    if name not in __all__:
        raise AttributeError(f"module 'pipeline' has no attribute {name!r}")
    from pipeline import notebook

    return getattr(notebook, name)

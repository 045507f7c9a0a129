"""A session with an effect that no catalogue has, and configurations that name it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.sessions import pipeline
from tests.world.designs import paper_design, rich_design

RICH = rich_design().scaled(sample_rate=0.1)
PAPER = replace(paper_design(), columns=rich_design().columns).scaled(sample_rate=0.2)


def variant(damp: Path, name: str, extra: str) -> Path:
    """The same session under another configuration, with results of its own."""
    config = damp.with_name(f"{name}.yaml")
    config.write_text(damp.read_text(encoding="utf-8") + extra, encoding="utf-8")
    return config


KINDS = """
effects:
  settle: {expression: exp(-time_s/tau), shapes: {tau: [s, 30, 7200]}, unit: rad/s}
  lean: {expression: f, per: matrix, unit: (rad/s)/(m/s²), triad: gyroscope}
  memory: {expression: tanh(p/3), unit: "{u}", triad: accelerometer}
  bent: {expression: f**2, unit: 1/(m/s²), triad: accelerometer}
  cross: {expression: other_x, per: common, unit: (m/s²)/(rad/s), triad: accelerometer}
  once: {expression: run('17rpm'), unit: rad/s, triad: gyroscope}
  damp: {expression: (humidity_pct - 45)**2, unit: rad/s per %², triad: gyroscope}
"""


def with_models(damp: Path, name: str, accelerometer: str = "", gyroscope: str = "") -> Path:
    """The session with these user-defined effects in its models."""
    text = damp.read_text(encoding="utf-8") + KINDS
    base = "model: [bias, scale, misalignment"
    first, second, third = text.split(base)
    added = [f", {names}" if names else "" for names in (accelerometer, gyroscope)]
    config = damp.with_name(f"{name}.yaml")
    config.write_text(first + base + added[0] + second + base + added[1] + third, "utf-8")
    return config


def corrected(results: Path, log: Path, *options: str) -> np.ndarray:
    """What ``apply`` makes of a log, columns as named."""
    output = results / "corrected.csv"
    assert pipeline("apply", results, log, "--output", output, *options) == 0
    return np.genfromtxt(output, delimiter=",", names=True)


SQUARE = """\
import numpy as np
def damp(at):
    square = (at.column('humidity_pct') - 45) ** 2
    return np.tile(square[:, None], 3)
"""


HEATING = """
effects:
  damp:  # swelling of the board, with the square of the humidity above 45 %
    expression: (humidity_pct - 45)**2
    unit: rad/s per %²
    triad: gyroscope
"""

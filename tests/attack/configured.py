"""Mistakes in the configuration of a session, drawn at random."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.world.session import Session

Rng = np.random.Generator
Edits = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Configuration:
    """A mistake in the configuration: regular expressions and what replaces them, with words.

    ``right`` are the claims (:mod:`tests.attack.claims`) that name it.
    """

    edits: Callable[[Rng, Session], tuple[str, Edits]]
    right: tuple[str, ...]


def _stated_rate(rng: Rng, session: Session) -> tuple[str, Edits]:
    """One rate of several is off, or its sd is far too small or too large."""
    name = str(rng.choice([*session.rates]))
    share = float(np.exp(rng.uniform(np.log(1e-4), np.log(0.05)))) * rng.choice([-1, 1])
    rate = abs(session.rates[name].rate_rad_s)
    return f"rate {name} off by {100 * share:.3g} %", (
        (rf"(  {name}: {{rate_rad_s: )[\d.]+", rf"\g<1>{rate * (1 + share):.9g}"),)


def _rate_sd(rng: Rng, session: Session) -> tuple[str, Edits]:
    sd = float(np.exp(rng.uniform(np.log(1e-9), np.log(0.1))))
    return f"sds of the rates {sd:.2g}", ((r"sd_rad_s: [\d.e-]+", f"sd_rad_s: {sd:.3g}"),)


def _gravity(rng: Rng, _session: Session) -> tuple[str, Edits]:
    value = float(rng.choice([9.7, 9.81, 9.75, 9.85, 9.9, 9.80665, 981.0, 1.0]))
    return f"gravity {value}", ((r"gravity_m_s2: [\d.]+", f"gravity_m_s2: {value}"),)


def _exchanged_files(_rng: Rng, session: Session) -> tuple[str, Edits]:
    names = [*session.rates]
    if len(names) < 2:
        return "rest and turning poses exchanged", (
            (r"gyroscope/17rpm/", "X/"), (r"accelerometer/pose", "gyroscope/17rpm/pose"),
            (r"X/", "accelerometer/"))
    return "the files of two runs exchanged", (
        (r"gyroscope/17rpm/", "X/"), (r"gyroscope/33rpm/", "gyroscope/17rpm/"),
        (r"X/", "gyroscope/33rpm/"))


def _full_scale(rng: Rng, _session: Session) -> tuple[str, Edits]:
    factor = float(rng.choice([0.25, 0.5, 2.0, 4.0, 8.0]))
    return f"gyroscope's full scale times {factor}", (
        (r"full_scale_deg_s: ([\d.]+)", f"full_scale_deg_s: {150 * factor:g}"),)


def _bits(rng: Rng, _session: Session) -> tuple[str, Edits]:
    bits = int(rng.choice([10, 12, 14, 15, 17, 18, 24]))
    return f"{bits} bits", ((r"bits: 16", f"bits: {bits}"),)


def _encoding(_rng: Rng, session: Session) -> tuple[str, Edits]:
    other = ("twos-complement" if session.design.sensor.accelerometer.offset_binary
             else "offset-binary")
    return f"encoding {other}", ((r"encoding: [a-z-]+", f"encoding: {other}"),)


def _twice(_rng: Rng, _session: Session) -> tuple[str, Edits]:
    return "the poses at rest stand in the run of the plate too", (
        (r"poses: gyroscope/17rpm/pose_\*\.csv",
         "poses: [accelerometer/pose_*.csv, gyroscope/17rpm/pose_*.csv]"),)


SHEET = "not turning, or data sheet"
CONFIGURATIONS: dict[str, Configuration] = {
    "stated rate": Configuration(_stated_rate, ("rate", "rate_scatter", "gains of runs")),
    "sd of the rate": Configuration(_rate_sd, ("rate", "rate_scatter", "sds")),
    "gravity": Configuration(_gravity, ("gravity",)),
    "files": Configuration(_exchanged_files, ("rate", SHEET)),
    "full scale": Configuration(_full_scale, ("data sheet", SHEET)),
    "bits": Configuration(_bits, ("data sheet", SHEET)),
    "twice": Configuration(_twice, ("rate", SHEET, "copied", "bad pose")),
    "encoding": Configuration(_encoding, ("data sheet",)),
}

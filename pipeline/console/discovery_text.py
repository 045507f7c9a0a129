"""Text on a discovered formula: the sentence, its picture, and the lines that define it."""

from collections.abc import Iterator

import numpy as np

from calib.diagnosis.verdict.wording import minutes_of
from calib.discovery.discover import Discovered
from calib.discovery.response import READING
from calib.effects.units import display_unit
from calib.poses.conditions import RUN_COLUMN
from calib.poses.imu_log import AXES
from calib.rounding import with_sd
from pipeline.next_change import MOST_ALIKE, definition, without_formula
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY

BARS = "▁▂▃▄▅▆▇█"
PICTURE_WIDTH = 40  #: characters of a picture at most: chosen


def answer_lines(result: TriadResult, found: Discovered | None) -> Iterator[str]:
    """The formula, or the sentence where none holds."""
    if found is None:
        yield no_formula(result)
    else:
        yield from discovery_lines(result, found)


def discovery_lines(result: TriadResult, found: Discovered) -> Iterator[str]:
    """The sentence, the figures, the picture and the definition."""
    formula = found.formula
    odds = min(found.log_odds / np.log(10), 99)
    text = (
        f"{result.triad}: {formula.words}. Poses that took no part err by "
        f"{found.left_out_before:.3g} sd without it and by {found.left_out_after:.3g} sd with it; "
        f"the odds for it are 10^{odds:.0f} to 1. {_size(found)}"
    )
    if found.listed is not None:
        yield (f"{text} The listed effect '{found.listed}' predicts these poses as well "
               f"({found.left_out_listed:.3g} sd) and has a name: it is the one to add.")
        return
    if found.alike:
        alike = "; ".join(each.words for each in found.alike[:MOST_ALIKE])
        more = len(found.alike) - MOST_ALIKE
        text += f" In these poses it looks the same as: {alike}"
        text += f"; and {more} more." if more > 0 else "."
    of_run = formula.column.startswith(RUN_COLUMN)
    if of_run:
        text += (" A run that differs is no physics of the sensor: look for a stated rate that is "
                 "off and for another clamping first.")
    yield text
    if formula.column and not of_run:
        yield from _picture(result, found)
    yield "effects:"
    yield f"  {formula.name}: {definition(result.triad, found)}"


def _size(found: Discovered) -> str:
    """The largest coefficient with its sd and unit, as a sentence."""
    fit, effect = found.fit, found.formula.effect
    where = fit.model.slices()[found.formula.name]
    sizes, sds = fit.theta[where], np.sqrt(np.diag(fit.cov))[where]
    k = int(np.argmax(np.abs(sizes)))
    unit, factor = display_unit(effect.unit, sizes)
    return (f"Its largest coefficient ({effect.parameters[k]}) is "
            f"{with_sd(factor * float(sizes[k]), factor * float(sds[k]))} {unit}.")


def _picture(result: TriadResult, found: Discovered) -> Iterator[str]:
    """The error of the axis that it changes most, along the column that it follows."""
    poses, fit = found.fit.poses, found.fit
    theta = fit.theta[fit.model.slices()[found.formula.name]]
    errors = fit.columns_of(found.formula.effect) @ theta
    axis = int(np.argmax((errors**2).mean(axis=0)))
    column = (fit.equations.at_reading.vector[:, axis] if found.formula.column == READING
              else poses.time_s if found.formula.column == "time_s"
              else poses.columns[found.formula.column])
    unit, factor = DISPLAY[result.triad]
    of_axis = factor * np.abs(errors[:, axis])
    edges = np.linspace(column.min(), column.max(), PICTURE_WIDTH + 1)
    place = np.clip(np.digitize(column, edges) - 1, 0, PICTURE_WIDTH - 1)
    largest = max(float(of_axis.max()), np.finfo(float).tiny)
    bars = "".join(
        BARS[int(of_axis[place == k].mean() / largest * (len(BARS) - 1))]
        if (place == k).any() else " " for k in range(PICTURE_WIDTH))
    yield (f"  |error of {AXES[axis]}| to {largest:.3g} {unit} along {found.formula.column} "
           f"{column.min():.4g} to {column.max():.4g}")
    yield f"  {bars}"


def no_formula(result: TriadResult) -> str:
    """The sentence where none holds."""
    said = result.diagnosis.explanation
    following = f"What the diagnosis says stands: {said.short}. {said.following}"
    if said.step == "discover":
        following = (
            "With these columns nothing more can be known of it: write it as your own effect if "
            "you know its physics, or log what may drive it (temperature, supply) and record the "
            f"same poses once more ({minutes_of(len(result.calibration.fit.poses))})")
    instead = without_formula(result)
    if instead is not None and said.step == "discover":
        following += f". Until then '{instead}' takes it into the sds"
    return (f"{result.triad}: no formula. None of those that were tried predicts poses that took "
            f"no part better than the model does. {following}.")

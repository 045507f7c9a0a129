"""Names, covariates and probabilities as a person would say them."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.diagnosis.hypotheses.listed import ANY_FUNCTION, ATTITUDE, OWN_AXIS
from calib.diagnosis.next_measurement.advice import list_labels, pose_in_words
from calib.diagnosis.next_measurement.pose_blocks import minutes_for
from calib.diagnosis.verdict.explanation import Step
from calib.effects.catalogue import find_effect
from calib.errors import CalibrationError
from calib.fit.least_squares.drawn_sizes import times_stated
from calib.fit.least_squares.result import Fit
from calib.fit.validation.prediction import Prediction
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import Triad
from calib.poses.triad_kind import TRIAD_KINDS
from calib.rounding import two_digits

MORE_THAN_NOISE = 5.0
"""Residuals five times the noise within the poses come from between them, and a formula of them is
looked for before they are called noise. A judgement: noise between poses seldom makes three."""

OTHER_FILES = "files of another sensor, range or unit, and for exchanged columns"

OF_ATTITUDE = {ATTITUDE: "what an axis senses"}  #: a covariate as a named effect has it

NOTHING_MORE = "Nothing more can be known of it from this sensor on this bench"

CORRECT = ("Correct a log, or hand the calibration to another program: the error to expect "
           "contains what is open")
"""Next step where something stays open."""

AT_REST = "no pose turned, so that scale and misalignment were neither determined nor tested"
"""What is open of a gyroscope that was at rest in all poses."""

NOTHING_MISSING = "Nothing is missing"  #: begins the text of that verdict


def physics(name: str) -> str:
    """What an effect is, as the end of a sentence that begins with its name."""
    try:
        words = find_effect(name).physics
    except CalibrationError:
        return "your own effect."
    return words[0].lower() + words[1:]


def missing(alike: Sequence[str]) -> str:
    """The sentences that name an effect as missing, or several that look the same, with a blank."""
    first = f"'{alike[0]}'"
    if len(alike) == 1:
        return f"{first} is missing: {physics(alike[0])} "
    every = enumeration([first, *map(readable, alike[1:])], "or")
    return (f"{every} is missing; they look the same here, so that these poses cannot determine "
            f"which. {first}: {physics(alike[0])} ")


def what_separates(name: str, triad: Triad) -> str:
    """What tells an effect from those that look the same: of ``triad`` where its page says so.

    >>> what_separates("cubic", "accelerometer")
    '26 poses or more'
    """
    try:
        words = find_effect(name).page.separates
    except CalibrationError:
        return "poses in which its columns change while everything else stays"
    for part in words.split("; "):
        of, colon, rest = part.partition(": ")
        if colon and of == TRIAD_KINDS[triad].word:
            return rest
    return words


def readable(name: str, follows: str | None = None, errs: str = "") -> str:
    """Description of a hypothesis, in words.

    Parameters
    ----------
    name : str
        An effect or a kind, as :class:`calib.diagnosis.hypotheses.listed.Hypothesis` has it.
    follows : str or None
        What it is a function of where it is an unknown function; ``name`` is then not looked at.
    errs : str
        What of the reading it then is.

    Returns
    -------
    str
        A phrase; an effect stands in quotes.

    Examples
    --------
    >>> readable("quadratic"), readable("bad_pose"), readable("", follows="time_s")
    ("'quadratic'", 'a bad pose', 'something that follows time')
    >>> readable("", "time_s", "gain"), readable("", "attitude", "error of each axis")
    ('a gain that follows time', 'an error of each axis that follows what it senses')
    """
    if name.startswith(ANY_FUNCTION):
        follows = name.removeprefix(ANY_FUNCTION)
    if follows is not None:
        what = f"a{'n' * errs.startswith('e')} {errs}" if errs else "something"
        return f"{what} that follows {covariate(follows, errs)}"
    return {
        "bad_pose": "a bad pose",
        "noise": "more noise than the poses show by themselves",
        "bias_wander": "a bias that wanders",
        "rate_scatter": "a plate whose rate scatters",
        "bias_step": "a step of the bias",
    }.get(name, f"'{name}'")


def covariate(name: str, errs: str = "") -> str:
    """Covariate of an unknown function, by which ``errs`` errs, in words."""
    if name == ATTITUDE and errs:
        return "what it senses" if errs == OWN_AXIS else "products of the specific force"
    return {
        "time_s": "time",
        "spin_rad_s": "the rate of the plate",
        "attitude": "the attitude in a way of third order or higher",
        "previous": "the pose before",
    }.get(name, f"the logged column {name}")


def curves(subjects: Sequence[str]) -> str:
    """A sentence on what an effect was named of where another function of it looks the same."""
    return "".join(
        f"Another function of {OF_ATTITUDE.get(name, covariate(name))} looks the same in these "
        f"poses, which saw too few values of it: poses at others would show which it is. "
        for name in subjects
    )


def at_times(times: Sequence[str]) -> str:
    """Times of a session, which a log need not count from zero.

    >>> at_times(["31.2 s", "50.0 s"])
    'at 31.2 s and 50.0 s after the first sample'
    """
    return f"at {enumeration(times, 'and')} after the first sample"


def odds_in_words(probability: float) -> str:
    """``9 in 10``: a probability as one would say it.

    Parameters
    ----------
    probability : float

    Returns
    -------
    str

    Examples
    --------
    >>> odds_in_words(0.63), odds_in_words(0.04), odds_in_words(0.996)
    ('6 in 10', '4 in 100', 'more than 99 in 100')
    """
    if probability > 0.99:
        return "more than 99 in 100"
    if probability >= 0.945:
        return f"{100 * probability:.0f} in 100"
    if probability >= 0.095:
        return f"{10 * probability:.0f} in 10"
    if probability >= 0.01:
        return f"{100 * probability:.0f} in 100"
    return "less than 1 in 100"


def rates_by_the_readings(fit: Fit) -> str:
    """How far the rates of the runs are from what is stated, behind a sentence; "" without one."""
    reference = fit.poses.reference
    each_run = []
    for name, sds, column in zip(
            reference.common_names, fit.eta, reference.common.T, strict=True):
        turns = column > 0
        if name in reference.of_setting and turns.any():
            share = float(sds * np.mean(column[turns] / reference.magnitude[turns]))
            more = "more" if share > 0 else "less"
            each_run.append(f"the {name} is {100 * abs(share):.2g} % {more} than stated "
                         f"({abs(sds):.2g} of its sds)")
    return f": by the readings {enumeration(each_run, 'and')}" if each_run else ""


def enumeration(words: Sequence[str], last: str) -> str:
    """Words as an enumeration.

    Parameters
    ----------
    words : sequence of str
    last : str
        What stands before the last of them: ``and`` or ``or``.

    Returns
    -------
    str
        Empty without words.

    Examples
    --------
    >>> enumeration(["a", "b", "c"], "or")
    'a, b or c'
    """
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def remedy_of_noise(factor: float) -> str:
    """Advice on a residual of so many times the noise."""
    if factor > MORE_THAN_NOISE:
        return (
            "That is more than an unsteady base or short poses make of it: look for poses that "
            f"moved, for {OTHER_FILES}."
        )
    return "Longer poses and a firmer base usually help."


def noise_in_the_model(fit: Fit, name: str) -> tuple[str, str]:
    """Noise that the model has and nothing explains: in a few words, and in sentences."""
    times = times_stated(fit)
    what = f"noise is {two_digits(times)} times what the samples of the poses show"
    return f"its {what}, unexplained", (
        f"The {what}, and nothing explains it. {remedy_of_noise(times)} '{name}' in the model "
        f"makes the sds of the parameters contain it; no correction takes it away")


def step_of_noise(factor: float, from_run_to_run: bool) -> tuple[Step, str]:
    """What to do about a residual of so many times the noise, for programs and in words.

    What scatters from run to run is no formula of what a pose is.
    """
    if factor > MORE_THAN_NOISE and not from_run_to_run:
        return "discover", "Look for a formula of it: what the samples show is seldom so much less"
    return "add", ("Add it: the sds then contain it, and its size is printed; no correction takes "
                   "it away")


def beyond_parts(beyond: Mapping[str, float]) -> str:
    """Effects that would explain a misfit at so many times the size of real parts."""
    name = min(beyond, key=lambda each: beyond[each])
    first = ("is the latitude right, south of the equator negative?" if name == "earth_rate"
             else "look for bad poses first.")
    return (f"'{name}' would explain most of it, but would be {two_digits(beyond[name])} times the "
            f"largest that such sensors have: {first}")


def unsupported(fit: Fit, prediction: Prediction) -> str:
    """Where a calibration with nothing missing does not hold, or no pose checks it."""
    text = ""
    if not prediction.holds_everywhere:
        worst = direction_name(prediction.weakest, fit.poses.triad)
        text = (
            f"But the calibration is weak with {worst}: a corrected magnitude is "
            f"{two_digits(prediction.times_a_pose)} times as uncertain there as one pose would "
            f"make it. "
        )
    if prediction.unchecked:
        alone = list_labels([pose_in_words(fit, one) for one in prediction.unchecked])
        text += (
            f"An error in one of these poses would go unnoticed, because the fit would follow it: "
            f"{alone}. Repeat them. "
        )
    return text


def kind_of_noise(names: Sequence[str]) -> str:
    """A sentence on the kind of noise, the first of ``names``; the others look the same."""
    if not names:
        return ""
    others = enumeration([f"'{name}'" for name in names[1:]], "and")
    alike = f"In these poses {others} look{'s' if len(names) == 2 else ''} the same. "
    return f"It is '{names[0]}': {physics(names[0])} {alike if others else ''}"


def minutes_of(poses: int) -> str:
    """Time to record so many poses, in words."""
    return f"{minutes_for(poses):.0f} min"

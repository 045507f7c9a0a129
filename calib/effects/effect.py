r"""An effect is a set of columns.

For every pose an effect states the error of the reading, in SI units, per unit of each of its k
parameters: an array (n, 3, k). An effect on the reference states the error of its magnitude:
(n, k). A model is a sum of effects, so that one function serves correction, fit, exact Jacobian,
identifiability, diagnosis and the catalogue.

Four places where an effect can act, and the vector its columns are evaluated on:

- ``reading``: bias, scale and misalignment, on the nominal reading y of eq. (12). They make up the
  linear form ``M y + c`` of Angrisano et al. eq. (1), one to one with (alpha, b, k).
- ``sensor``: everything added to it, on what the sensitive axes sense, ``u = T⁻¹ s`` with s the
  corrected vector in orthogonal axes and T of eq. (2); s solves ``s + T F(T⁻¹ s) theta = M y + c``.
  Parameters so mean the same in simulation, correction and fit. What belongs to the motion and not
  to an axis (a lever arm, a rotation of the frame) is ``orthogonal``: its columns take s itself.
- ``reference``: the plate rate or gravity value m itself.
- ``noise``: the sds of the rows, by coefficients with a prior (:mod:`calib.effects.drawn`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from calib.effects.typical import Typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import SI_UNIT, BoolArray, FloatArray, Triad
from calib.poses.past import Past
from calib.poses.triad_kind import TRIAD_KINDS

REFERENCE_TEMPERATURE_C = 25.0
"""Temperature at which bias and scale are quoted once a temperature effect is in the model. Fact:
data sheets state theirs at 25 °C."""

Columns = Callable[..., FloatArray]

ShapeValue = float | FloatArray
"""A shape parameter: one value, or (n, 1) a value for each row, which listed effects take too."""

Need = Literal["force", "time", "previous", "vibration", "plate"]
"""Inputs of the columns of an effect besides the vector itself, as the fields of
:class:`calib.poses.conditions.Conditions`: the specific force; the time since the session began;
the pose before; the vibration within the pose; the plate's rate and the reference magnitude."""

ConstantPart = Literal["bias", "scale"]

Place = Literal["reading", "sensor", "reference", "noise"]
"""Place where an effect acts; an effect on the noise is drawn anew (:mod:`calib.effects.drawn`)."""

Draw = Literal["", "as_noise", "per_pose", "in_time"]
"""How the coefficients of an effect are drawn: not at all, they are parameters; with each pose in
proportion to its own sd; with each pose; or along the time of the session."""

Owner = Literal["sensor", "session", "bench"]
"""Whose an effect is. The sensor's goes wherever the sensor goes; the session's holds on the clock
of one session; the bench's stays with the plate, its camera and where the sensor stood on it."""

Told = Literal["sample", "clock", "nothing", "bench"]
"""What tells an effect in a log other than those of the calibration: each sample, with the logged
columns; only the clock of the calibration session; nothing, of an effect of whole poses and of what
is drawn anew; or nothing has to, of the bench, which stays behind."""

UNTOLD: tuple[Need, ...] = ("previous", "vibration", "plate")
"""Needs that no sample of another log meets: they are facts of poses on the plate."""

AT_BOUND = 1e-3
"""Relative distance within which a shape parameter is at its bound. Numerical: a step ends on the
bound itself; half and twice change none of 55 verdicts."""


@dataclass(frozen=True)
class Shape:
    """A parameter in which the columns are not linear, fitted by its profile.

    Attributes
    ----------
    name, unit : str
    starts : tuple of float
        Values that are tried first, in ``unit``.
    bounds : tuple of float
        Lowest and highest value of a fit, in ``unit``.
    is_fitted : bool
        Whether it moves in a fit; False where only its starts are tried, or the one there is.
    """

    name: str
    unit: str
    starts: tuple[float, ...]
    bounds: tuple[float, float]
    is_fitted: bool = True

    def is_at_bound(self, value: float | FloatArray) -> BoolArray:
        """Whether values, a number or an array (S,), stand at an end of the range, or are NaN."""
        low, high = self.bounds
        inside = np.greater(value, low * (1 + AT_BOUND)) & np.less(value, high * (1 - AT_BOUND))
        return np.logical_not(inside)


@dataclass(frozen=True)
class Page:
    """Facts on an effect that a user should know before adding it.

    ``typical`` maps a class of parts to its sizes; ``confounded`` and ``separates`` say what
    looks the same in which data, and the measurement that tells them apart. ``expressions`` are its
    columns once more, in the language of :mod:`calib.effects.expression` and in the arrangement of
    :mod:`calib.effects.formula`, for programs that cannot call the effect: none where the samples
    of a log do not determine it.
    """

    formula: str
    typical: Mapping[str, Typical]
    source: str
    confounded: str
    separates: str
    expressions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Effect:
    """One physical effect: its columns, its parameters and its page in the catalogue.

    Parameters
    ----------
    name : str
    parameters : tuple of str
        What its k parameters are called.
    unit : str
        Of every parameter, ``{u}`` standing for the SI unit of the triad.
    columns : callable
        From :class:`calib.poses.conditions.Conditions` of n rows (and the shape parameter where
        there is one) to (n, 3, k), or (n, k) for an effect on the reference.
    physics : str
        One sentence.
    page : Page
    acts_on : str
        ``reading``, ``sensor``, ``reference`` or ``noise``; see the module's docstring.
    only_for : tuple of str
        The triads that it is for; empty where it is for every triad.
    shape : Shape or None
    needs : tuple of str
        What its columns are made of besides the vector; see :data:`Need`.
    logged : tuple of str
        Columns of the log that it reads.
    pasts : tuple of Past
        What it reads of the past of them.
    belongs_to : str
        ``sensor``, ``session`` or ``bench``; see :data:`Owner`.
    constant_is : str or None
        The effect of the base that it is where its conditions do not vary.
    orthogonal : bool
        Whether an effect on the sensor acts on the orthogonal axes instead of the sensitive ones.
    in_square : bool
        Whether the length of the vector shows it from the square of its parameters on only: its
        derivative vanishes where they are zero.
    names_column : str or None
        Logged column whose linear effect on the bias this is: ``column:NAME`` would say the same.
    contains : tuple of str
        Effects whose columns are among its own, so that no model has both.
    follows_words : str
        What its columns follow where no single condition drives them, for the axis of a chart;
        ``{axis}`` and ``{parameter}`` stand for theirs. By default the formula.
    largest : float or None
        No parameter of it exceeds this in nature, SI; None where the sizes of its page say it.
    alike : tuple of str
        What the poses in which it was found do not tell from it, as expressions.
    drawn : str
        How its coefficients are drawn where only their size is a parameter; see :data:`Draw`.
    starts_in : callable or None
        From the poses at hand (their :class:`calib.poses.conditions.Conditions`) to the starts of
        its shape parameter there.
    """

    name: str
    parameters: tuple[str, ...]
    unit: str
    columns: Columns
    physics: str
    page: Page
    acts_on: Place = "sensor"
    only_for: tuple[Triad, ...] = ()
    shape: Shape | None = None
    needs: tuple[Need, ...] = ()
    logged: tuple[str, ...] = ()
    pasts: tuple[Past, ...] = ()
    belongs_to: Owner = "sensor"
    orthogonal: bool = False
    in_square: bool = False
    constant_is: ConstantPart | None = None
    names_column: str | None = None
    contains: tuple[str, ...] = ()
    follows_words: str = ""
    largest: float | None = None
    alike: tuple[str, ...] = ()
    drawn: Draw = ""
    starts_in: Callable[[Conditions], tuple[float, ...]] | None = None

    @property
    def triads(self) -> tuple[str, ...]:
        """Every triad that it is for."""
        return self.only_for or tuple(TRIAD_KINDS)

    @property
    def told_by(self) -> Told:
        """What tells it in another log; apply, the exports and the error to expect decide by it."""
        if self.belongs_to == "bench":
            return "bench"
        if self.drawn or not {*UNTOLD}.isdisjoint(self.needs):
            return "nothing"
        return "clock" if "time" in self.needs else "sample"

    def unit_for(self, triad: str) -> str:
        """Unit of the parameters when the effect acts on ``triad``."""
        return self.unit.replace("{u}", SI_UNIT[triad])

    def evaluate(self, at: Conditions, shape: ShapeValue | None = None) -> FloatArray:
        """The columns of the effect.

        Parameters
        ----------
        at : Conditions
            n rows.
        shape : float or array, shape (n, 1), optional
            Value of the shape parameter, in its unit; by default the first of its starts.

        Returns
        -------
        array, shape (n, 3, k), or (n, k) for an effect on the reference
            Error in SI units per unit of each of the k parameters.
        """
        if self.shape is None:
            return self.columns(at)
        return self.columns(at, self.shape.starts[0] if shape is None else shape)

    @property
    def is_column(self) -> bool:
        """Whether it is ``column:NAME``, which no catalogue lists."""
        return self.names_column is not None and self.name == OF_COLUMN + self.names_column

    def within(self, at: Conditions) -> "Effect":
        """The same effect with the starts that its shape parameter has in poses at ``at``."""
        starts = self.starts_in(at) if self.starts_in is not None else ()
        if self.shape is None or not starts:
            return self
        return replace(self, shape=replace(self.shape, starts=starts))

    def from_shape(self, value: float) -> "Effect":
        """The same effect with ``value`` as the first start of its shape parameter."""
        assert self.shape is not None
        return replace(self, shape=replace(self.shape, starts=(value, *self.shape.starts)))


OF_COLUMN = "column:"
"""Followed by the column: the name of a bias that follows it."""

EFFECTS: dict[str, Effect] = {}
"""Every listed effect by name, in the order of the catalogue."""


def effect(*parameters: str, **fields: Any) -> Callable[[Columns], Columns]:
    """Register the decorated column function under its own name; its docstring is the physics.

    ``fields`` are those of :class:`Effect`, by name.

    Registered, the effect has its page in the catalogue and can be named in a model, diagnosed,
    added, applied to other logs, and exported where its page has expressions.
    """

    def register(function: Columns) -> Columns:
        name = function.__name__
        physics = " ".join((function.__doc__ or "").split())
        EFFECTS[name] = Effect(
            name=name, parameters=parameters, columns=function, physics=physics, **fields)
        return function

    return register


def per_axis(values: FloatArray) -> FloatArray:
    """Columns of an effect whose axis k errs by ``values[:, k]`` times parameter k.

    Parameters
    ----------
    values : array, shape (n, 3)
        SI units per unit of the parameter.

    Returns
    -------
    array, shape (n, 3, 3)
        SI per unit of each parameter.
    """
    columns = np.zeros((len(values), 3, 3))
    columns.reshape(-1, 9)[:, ::4] = values
    return columns

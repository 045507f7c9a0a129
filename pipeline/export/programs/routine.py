"""Steps of a program that corrects one triad, independent of its language.

    w = K (counts - b)            nominal by the calibration, in the sensitive axes
    u = w - e(u)                  by fixed point, where the model has effects
    s = T u                       in orthogonal axes, SI

The errors e of the sensor are expressions from the pages of its effects.
"""

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import OF_COLUMN, Effect
from calib.effects.expression import substituted
from calib.effects.formula import axis_terms
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, SI_UNIT, TEMPERATURE, FloatArray
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.export.parts import EXAMPLE_DIRECTION, ONE_G, example_counts, plain_row
from pipeline.results.read import StoredTriad
from pipeline.text.plain import one_line

FORCE = tuple(f"f{axis}" for axis in AXES)


@dataclass(frozen=True)
class Product:
    """``factor * value``, value an expression of numbers and names."""

    factor: float
    value: ast.expr


@dataclass(frozen=True)
class ErrorFormula:
    """The error that an effect adds to each axis, SI, as sums of products.

    ``x``, ``y``, ``z`` are the vector in the sensitive axes. ``names`` are the other names of the
    expressions: conditions that a caller passes.
    """

    effect: str
    axes: tuple[tuple[Product, ...], ...]
    names: tuple[str, ...]


def error_formula(
    effect: Effect, theta: FloatArray, shape: float | None, calibrated: StoredTriad
) -> ErrorFormula | None:
    """The error of one effect of a calibration.

    Parameters
    ----------
    effect : Effect
    theta : array, shape (k,)
        Its parameters, SI.
    shape : float or None
        The value of its shape parameter.
    calibrated : StoredTriad

    Returns
    -------
    ErrorFormula or None
        None where samples do not determine it (hysteresis, vibration, the bench), or where its
        page has no expressions.
    """
    if effect.acts_on != "sensor" or effect.told_by in ("bench", "nothing"):
        return None
    terms = axis_terms(effect, shape)
    if not terms:
        return None
    axes = tuple(tuple(Product(float(theta[term.parameter]), term.value) for term in axis)
                 for axis in terms)
    if effect.orthogonal:
        axes = _turned_to_sensitive_axes(axes, calibrated.alignment)
    if calibrated.name == "accelerometer":  # which measures the specific force itself
        vector = {name: ast.Name(axis) for name, axis in zip(FORCE, AXES, strict=True)}
        axes = tuple(tuple(Product(one.factor, substituted(one.value, vector)) for one in axis)
                     for axis in axes)
    names = dict.fromkeys(name for axis in axes for one in axis for name in _names(one.value))
    return ErrorFormula(effect.name, axes, tuple(names))


def _names(tree: ast.expr) -> list[str]:
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    return [node.id for node in ast.walk(tree)
            if isinstance(node, ast.Name) and id(node) not in called
            and node.id not in (*AXES, "pi")]


def _turned_to_sensitive_axes(
    axes: tuple[tuple[Product, ...], ...], alignment: FloatArray
) -> tuple[tuple[Product, ...], ...]:
    """``T⁻¹ e(T u)`` of an error e(s) in orthogonal axes, which are ``s = T u``."""
    inverse = np.linalg.inv(alignment)
    orthogonal = {name: _weighted(row) for name, row in zip(AXES, alignment, strict=True)}
    return tuple(
        tuple(Product(float(inverse[i, j]) * axis.factor, substituted(axis.value, orthogonal))
              for j in range(len(AXES)) if inverse[i, j] != 0 for axis in axes[j])
        for i in range(len(AXES)))


def _weighted(row: FloatArray) -> ast.expr:
    """The sum of x, y, z with the weights of a row of T."""
    parts: list[ast.expr] = [
        ast.BinOp(ast.Constant(float(weight)), ast.Mult(), ast.Name(axis))
        for weight, axis in zip(row, AXES, strict=True) if weight != 0]
    total = parts[0]
    for part in parts[1:]:
        total = ast.BinOp(total, ast.Add(), part)
    return total


STEPS = 50  #: most steps of the fixed point, as in :mod:`calib.fit.rows.sensitive_axes`

#: Conditions with a name of their own, and their descriptions.
MEANINGS: Mapping[str, str] = {
    TEMPERATURE: "temperature in degrees Celsius",
    "other_x": "reading of the other triad by the data sheet, SI",
    "other_y": "reading of the other triad by the data sheet, SI",
    "other_z": "reading of the other triad by the data sheet, SI",
}
#: Values of conditions in the worked example.
EXAMPLE_CONDITIONS: Mapping[str, float] = {TEMPERATURE: 30.0, "time_s": 60.0}
EXAMPLE_CONDITION = 1.0  #: value of any other column, in its unit: an example only


@dataclass(frozen=True)
class Input:
    """A condition that the caller passes.

    ``name`` is that in the expressions, ``column`` that in the log, ``identifier`` that of the
    argument, ``meaning`` words.
    """

    name: str
    column: str
    identifier: str
    meaning: str


@dataclass(frozen=True, eq=False)
class Routine:
    """The correction of one triad.

    ``bias`` in counts and ``gain`` in SI units per count, (3,); ``alignment`` T (3, 3);
    ``wraps_at`` the number of codes of a converter whose negative counts are logged as large ones;
    ``needs_force`` whether it takes the specific force; ``left_out`` the effects that samples do
    not determine.
    """

    triad: str
    bias: FloatArray
    gain: FloatArray
    alignment: FloatArray
    wraps_at: int | None
    formulas: tuple[ErrorFormula, ...]
    needs_force: bool
    inputs: tuple[Input, ...]
    left_out: tuple[str, ...]
    example: str

    @property
    def prefix(self) -> str:
        """Prefix of the names of its constants."""
        return TRIAD_KINDS[self.triad].prefix.upper()

    @property
    def unit(self) -> str:
        """SI unit of its output."""
        return SI_UNIT[self.triad]

    @property
    def arguments(self) -> tuple[tuple[str, str], ...]:
        """Name and meaning of every argument, in order."""
        force = [("force", "specific force in m/s², as calibrate_accelerometer returns it")]
        return (("counts", "readings as logged"), *(force if self.needs_force else ()),
                *((one.identifier, one.meaning) for one in self.inputs))


def routine_of(triad: StoredTriad) -> Routine:
    """The correction of one triad with every effect that samples determine."""
    correction = triad.correction
    formulas, left_out = [], []
    for effect in correction.model.effects:
        if effect.acts_on == "reading":
            continue
        theta = correction.theta[correction.model.positions([effect])]
        formula = error_formula(effect, theta, correction.shapes.get(effect.name), triad)
        if formula is None:
            left_out.append(effect.name)
        else:
            formulas.append(formula)
    names = tuple(dict.fromkeys(name for formula in formulas for name in formula.names))
    spec = correction.spec
    inputs = _inputs([name for name in names if name not in FORCE], triad.end_s)
    return Routine(
        triad.name, triad.parameters.bias_counts, triad.units_per_count, triad.alignment,
        2**spec.bits if spec.encoding == "unsigned-twos-complement" else None,
        tuple(formulas), any(name in FORCE for name in names), inputs, tuple(left_out),
        _example(triad, {formula.effect for formula in formulas}, inputs,
                 any(name in FORCE for name in names)),
    )


def _inputs(names: list[str], end_s: float) -> tuple[Input, ...]:
    """Arguments with distinct names that every language accepts; the session ends at ``end_s``."""
    inputs: list[Input] = []
    meanings = {**MEANINGS, "time_s": f"seconds since the calibration session began; of a log of "
                                      f"another time its end, {end_s:.6g}"}
    for name in names:
        column, identifier = name.removeprefix(OF_COLUMN), name
        if name not in meanings:
            identifier = base = "column_" + re.sub(r"[^A-Za-z0-9]+", "_", column).strip("_")[:40]
            number = 2
            while any(one.identifier == identifier for one in inputs):
                identifier, number = f"{base}_{number}", number + 1
        meaning = meanings.get(name, f"the logged column {one_line(column)}")
        inputs.append(Input(name, column, identifier, meaning))
    return tuple(inputs)


def _example(
    triad: StoredTriad, held: set[str], inputs: tuple[Input, ...], needs_force: bool
) -> str:
    """A reading and its correction, in one line."""
    counts = example_counts(triad)
    values = {one.column: EXAMPLE_CONDITIONS.get(one.column, EXAMPLE_CONDITION) for one in inputs}
    force = EXAMPLE_DIRECTION * ONE_G
    columns = {name: np.array([value]) for name, value in values.items()}
    at = Conditions.of_vectors(
        triad.correction.spec.nominal(counts)[None], columns, force=force[None],
        time_s=columns.get("time_s", np.zeros(1)))
    si = triad.correction.sensor_part(held).correct(at)[0]
    listed = [f"force ({plain_row(force)})"] if needs_force else []
    listed += [f"{one.identifier} {values[one.column]:g}" for one in inputs]
    conditions = f" at {', '.join(listed)}" if listed else ""
    codes = counts if triad.correction.spec.encoding != "unsigned-twos-complement" else (
        counts % 2**triad.correction.spec.bits)
    return f"counts ({plain_row(codes)}) are ({plain_row(si)}) {SI_UNIT[triad.name]}{conditions}"

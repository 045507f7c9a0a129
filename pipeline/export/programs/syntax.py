"""The complete correction as source code in three languages: expressions, and a template each."""

import ast
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from jinja2 import Environment, PackageLoader, StrictUndefined

from calib.poses.imu_log import AXES
from pipeline.export.parts import Export, lost_effects, no_sds, origin
from pipeline.export.programs.routine import FORCE, STEPS, Product, Routine, routine_of
from pipeline.results.read import Stored
from pipeline.text.plain import ascii_line

OPERATORS: Mapping[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
}
COMMENT_SIGNS = re.compile(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)")
DOUBLE_TOLERANCE = "1e-14"
"""Relative change that ends the fixed point in double precision: 45 roundings. As text, since each
language writes it so."""
FLOAT_TOLERANCE = "1e-6f"  #: the same of a float, which has 6e-8


@dataclass(frozen=True)
class Syntax:
    """How a language writes numbers, powers, functions, operators, variables and comments.

    ``operators`` replaces those of Python; ``functions`` maps ours to templates of one argument.
    ``component`` writes a component 0, 1, 2 of the vector ``u`` or ``force``, ``column`` the
    argument of a logged column; ``comment`` a line without control characters; ``tolerance`` ends
    the fixed point.
    """

    number: Callable[[float], str]
    power: Callable[[str, float], str]
    functions: Mapping[str, str]
    component: Callable[[str, int], str]
    comment: Callable[[str], str]
    tolerance: str = DOUBLE_TOLERANCE
    column: str = "{0}"
    operators: Mapping[str, str] = field(default_factory=dict)

    def errors(self, routine: Routine) -> list[str]:
        """The error e(u) of x, y and z by all effects of a routine."""
        names = {axis: self.component("u", i) for i, axis in enumerate(AXES)}
        names |= {axis: self.component("force", i) for i, axis in enumerate(FORCE)}
        names |= {one.name: self.column.format(one.identifier) for one in routine.inputs}
        return [" + ".join(self._product(product, names) for formula in routine.formulas
                           for product in formula.axes[i]) for i in range(len(AXES))]

    def _product(self, product: Product, names: Mapping[str, str]) -> str:
        value = self._text(product.value, names)
        return f"{self.number(product.factor)} {self.operators.get('*', '*')} {value}"

    def _text(self, node: ast.expr, names: Mapping[str, str]) -> str:
        """The node as an operand: in brackets where it has operators."""
        match node:
            case ast.Constant(value=int() | float() as number):
                return self.number(float(number))
            case ast.Name(id="pi"):
                return self.number(math.pi)
            case ast.Name(id=name):
                return names[name]
            case ast.UnaryOp(op=operator, operand=operand):
                sign = "-" if isinstance(operator, ast.USub) else ""
                return f"({sign}{self._text(operand, names)})"
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self.power(self._text(left, names), float(ast.literal_eval(right)))
            case ast.BinOp(left=left, op=operator, right=right):
                sign = OPERATORS[type(operator)]
                sign = self.operators.get(sign, sign)
                return f"({self._text(left, names)} {sign} {self._text(right, names)})"
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return self.functions[name].format(self._text(argument, names))
        raise AssertionError(ast.dump(node))  # read_expression admits nothing else


def c_float(value: float) -> str:
    """A C constant of type float: it needs a point or an exponent before its f."""
    text = f"{value + 0.0:.9g}"
    return f"{text}f" if any(sign in text for sign in ".e") else f"{text}.0f"


def c_row(values: Iterable[float]) -> str:
    """Constants separated by commas."""
    return ", ".join(c_float(float(value)) for value in values)


def c_comment(line: str) -> str:
    """A C comment; text that would end or begin a comment is parted, trigraphs too."""
    return f"/* {COMMENT_SIGNS.sub(' ', ascii_line(line))} */"


def hash_comment(line: str) -> str:
    """A comment of Python, of parameter files and of command lines."""
    return f"# {ascii_line(line)}"


def _c_power(base: str, exponent: float) -> str:
    whole = int(exponent)
    if whole == exponent and whole > 0:
        return f"({' * '.join([base] * whole)})"
    return f"powf({base}, {c_float(exponent)})"


def _python_power(base: str, exponent: float) -> str:
    whole = int(exponent)
    return f"({base} ** {whole})" if whole == exponent else f"(math.pow({base}, {exponent!r}))"


def _exact(value: float) -> str:
    return repr(float(value))


SMOOTH = ("cos", "exp", "log", "sin", "sqrt", "tanh")  #: functions of these names in every language

#: C89 but for ``inline``, single precision, nothing but ``math.h``.
C = Syntax(
    number=c_float,
    power=_c_power,
    functions={name: f"{name}f({{0}})" for name in SMOOTH}
    | {"abs": "fabsf({0})", "sign": "(float)(({0} > 0.0f) - ({0} < 0.0f))"},
    component=lambda vector, i: f"{vector}[{i}]",
    comment=c_comment,
    tolerance=FLOAT_TOLERANCE,
)

#: A module that imports nothing but ``math``.
PYTHON = Syntax(
    number=_exact,
    power=_python_power,
    functions={name: f"math.{name}({{0}})" for name in SMOOTH}
    | {"abs": "abs({0})", "sign": "(({0} > 0) - ({0} < 0))"},
    component=lambda vector, i: f"{vector}[{i}]",
    comment=hash_comment,
)

#: MATLAB and Octave, of whole logs: a row for each sample.
MATLAB = Syntax(
    number=_exact,
    power=lambda base, exponent: f"({base} .^ ({exponent!r}))",
    functions={name: f"{name}({{0}})" for name in (*SMOOTH, "abs", "sign")},
    component=lambda vector, i: f"{vector}(:, {i + 1})",
    comment=lambda line: f"% {ascii_line(line)}",
    column="{0}(:)",
    operators={"*": ".*", "/": "./"},
)


def to_arduino(stored: Stored) -> Export:
    """``imu_calibration.h``: one function for each triad, with a worked number."""
    routines = _routines(stored)
    text = _source("imu_calibration.h", C, stored, routines)
    return Export({"imu_calibration.h": text}, _notes(stored, routines, "The header"))


def to_python(stored: Stored) -> Export:
    """``imu_calibration.py``: one function for each triad, plain numbers in and out."""
    routines = _routines(stored)
    text = _source("imu_calibration.py", PYTHON, stored, routines)
    return Export({"imu_calibration.py": text}, _notes(stored, routines, "The module"))


def to_matlab(stored: Stored) -> Export:
    """``calibrate_accelerometer.m`` and ``calibrate_gyroscope.m``."""
    routines = _routines(stored)
    files = {f"calibrate_{one.triad}.m": _source("calibrate.m", MATLAB, stored, [one])
             for one in routines}
    return Export(files, _notes(stored, routines, "The function"))


def _routines(stored: Stored) -> list[Routine]:
    return [routine_of(triad) for triad in stored.triads]


def _source(
    template: str, syntax: Syntax, stored: Stored, routines: Sequence[Routine]
) -> str:
    environment = Environment(
        loader=PackageLoader("pipeline.export", "templates"), undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    environment.filters |= {"comment": syntax.comment, "number": syntax.number}
    return environment.get_template(f"{template}.jinja").render(
        routines=routines, origin=origin(stored), syntax=syntax, steps=STEPS)


def _notes(stored: Stored, routines: Sequence[Routine], program: str) -> tuple[str, ...]:
    """Effects that the program does not correct, and its assumptions."""
    notes: list[str] = [*no_sds(stored)]
    for triad, routine in zip(stored.triads, routines, strict=True):
        lost = [name for name in routine.left_out if name in triad.section.effects]
        notes += lost_effects(stored, triad, lost, program)
        if any(one.column == "time_s" for one in routine.inputs):
            timed = [one.effect for one in routine.formulas if "time_s" in one.names]
            notes.append(
                f"{', '.join(timed)} of the {triad.name} holds on the clock of the calibration "
                f"session: pass time_s in seconds since its first sample. On another day it is not "
                f"known.")
        further = [f"{one.identifier} ({one.meaning})" for one in routine.inputs
                   if one.column != "time_s"]
        further += ["force (the corrected specific force)"] if routine.needs_force else []
        if further:
            notes.append(f"calibrate_{triad.name} also takes {', '.join(further)}.")
    return tuple(notes)

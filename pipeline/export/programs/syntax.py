"""Expressions in the syntax of a programming language."""

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from calib.poses.imu_log import AXES
from pipeline.export.programs.errors import FORCE, Product
from pipeline.export.programs.routine import Routine

OPERATORS: Mapping[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
}


@dataclass(frozen=True)
class Syntax:
    """How a language writes numbers, powers, functions, operators and its variables.

    ``operators`` replaces those of Python; ``functions`` maps ours to templates of one argument.
    ``component`` writes a component 0, 1, 2 of the vector ``u`` or ``force``, ``column`` the
    argument of a logged column.
    """

    number: Callable[[float], str]
    power: Callable[[str, float], str]
    functions: Mapping[str, str]
    operators: Mapping[str, str]
    component: Callable[[str, int], str]
    column: Callable[[str], str]

    def errors(self, routine: Routine) -> list[str]:
        """The error e(u) of x, y and z by all effects of a routine."""
        names = {each: self.component("u", i) for i, each in enumerate(AXES)}
        names |= {each: self.component("force", i) for i, each in enumerate(FORCE)}
        names |= {each.column: self.column(each.identifier) for each in routine.inputs}
        return [" + ".join(self._product(each, names) for formula in routine.formulas
                           for each in formula.axes[i]) for i in range(len(AXES))]

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
        raise AssertionError(ast.dump(node))  # read_expression lets nothing else through

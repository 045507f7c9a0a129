"""Expressions in the syntax of a programming language."""

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipeline.export.programs.formulas import ErrorFormula, Product

OPERATORS: Mapping[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/",
}


@dataclass(frozen=True)
class Syntax:
    """How a language writes numbers, powers, functions and operators.

    ``operators`` replaces those of Python; ``functions`` maps ours to templates of one argument.
    """

    number: Callable[[float], str]
    power: Callable[[str, float], str]
    functions: Mapping[str, str]
    operators: Mapping[str, str]

    def sum_of(self, formulas: tuple[ErrorFormula, ...], axis: int, names: Mapping[str, str]) -> (
            str):
        """The error of one axis by all effects; ``names`` maps ours to those of the program."""
        terms = [self._product(each, names) for formula in formulas for each in formula.axes[axis]]
        return " + ".join(terms)

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

"""The numbers that decide something, as the code states them: for the page that lists all of them.

A number decides unless its description says otherwise in one of the words of ``NO_DECISION``.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from tests.source_tree import FILES, tree_of

#: Of a description: the number is a fact of arithmetic, of a definition, of text or of a picture,
#: or it limits memory.
NO_DECISION = re.compile(
    r"\b(numerical|definitions?|rounding|WGS84|limits? of (time and )?memory|(words|digits|plans)"
    r" only|only plans|of text|of a picture|its index)\b", re.IGNORECASE)
#: Where a number comes from.
ORIGIN = re.compile(r"\b(facts?|derived|tuned|judgement|chosen|limit of (time|size))\b",
                    re.IGNORECASE)


@dataclass(frozen=True)
class Threshold:
    """A number of a module, or several.

    Attributes
    ----------
    path : str
        Module and name, without the package.
    value : object
    description : str
        What stands below it, beside it or above it, on one line.
    """

    path: str
    value: Any
    description: str

    @property
    def cells(self) -> tuple[str, str, str]:
        """The first three cells of its row."""
        return f"`{self.path}`", written(self.value), self.description.replace("|", "\\|")


def written(value: Any) -> str:
    """A number, or several, to four digits."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {written(each)}" for key, each in value.items())
    if isinstance(value, tuple):
        return ", ".join(map(written, value))
    return f"{value:.4g}"


def thresholds(package: str) -> Iterator[Threshold]:
    """All numbers of a package that decide something, module by module."""
    for module in sorted(FILES):
        if not module.startswith(f"{package}."):
            continue
        lines = FILES[module].read_text(encoding="utf-8").splitlines()
        body = tree_of(module).body
        for node, after in zip(body, [*body[1:], None], strict=True):
            if not isinstance(node, ast.Assign | ast.AnnAssign) or not is_number(node.value):
                continue
            description = described(node, after, lines)
            if NO_DECISION.search(description):
                continue
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            for name in (ast.unparse(each) for each in names):
                value = getattr(import_module(module), name, None)
                if name.isupper() and not name.startswith("_") and are_numbers(value):
                    yield Threshold(f"{module.partition('.')[2]}.{name}", value, description)


def are_numbers(value: object) -> bool:
    """Whether a value is a number, or several with or without names."""
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, tuple):
        return bool(value) and all(map(are_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_number(node: ast.expr | None) -> bool:
    """Whether numbers stand in an expression."""
    return any(type(each.value) in (int, float) for each in ast.walk(node or ast.Pass())
               if isinstance(each, ast.Constant))


def described(node: ast.stmt, after: ast.stmt | None, lines: list[str]) -> str:
    """The docstring below a statement, or the comment at its end or above it."""
    if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
        return " ".join(str(after.value.value).split())
    beside = lines[(node.end_lineno or 0) - 1].partition("#:")[2].strip()
    if beside:
        return beside
    above = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.startswith("#:"):
            break
        above.append(line.removeprefix("#:").strip())
    return " ".join(reversed(above))

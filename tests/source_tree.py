"""The source files as syntax trees, for the tests that read the code."""

import ast
from functools import cache
from pathlib import Path

from tests.paths import ROOT

PACKAGES = ("pipeline", "vision", "calib")


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module_name(path): path for package in PACKAGES
         for path in sorted((ROOT / package).rglob("*.py"))}
TEST_FILES = {module_name(path): path for path in sorted((ROOT / "tests").rglob("*.py"))}


@cache
def tree_of(module: str) -> ast.Module:
    """Parsed when a test asks: every process of the tests collects this file."""
    return ast.parse((FILES | TEST_FILES)[module].read_text(encoding="utf-8"))


@cache
def imports(tree: ast.AST) -> tuple[tuple[str, str | None], ...]:
    """Module and, for ``from`` imports, name of every import, also those inside functions."""
    every: list[tuple[str, str | None]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            every += ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: imports are absolute"
            every += ((node.module or "", alias.name) for alias in node.names)
    return tuple(every)


def begins(name: str, home: str) -> bool:
    """``pipeline.config.rules`` begins with ``pipeline.config``, ``pipeline.configure`` not."""
    return name == home or name.startswith(f"{home}.")

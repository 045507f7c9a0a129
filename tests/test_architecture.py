"""What may import what, and the few rules of the house that a machine can check."""

import ast
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import COMMANDS
from tests.import_contract import EXTRAS, FLOORS, HOME, MAY_IMPORT
from tests.paths import ROOT
from tests.source_tree import FILES, PACKAGES, TEST_FILES, begins, imports, module_name, tree_of

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LONGEST_FILE = 300  #: lines

#: No result is called so: a name says what a thing is, not how it was come by.
NO_RESULTS = {"found", "given", "own", "says", "taken", "asked", "left", "made"}

#: Functions of one name that are one thing: commands, readers of log formats; one question to the
#: triads and to a clip; one of several stages in a package and the whole of it for a notebook.
ONE_THING = {"command", "tables", "diagnose", "measure_rate", "calibrate"}


def of_each(names: Iterable[Any]) -> Callable[[Callable[[Any], None]], Callable[[], None]]:
    """One test that checks each of ``names`` and lists those that fail."""

    def decorate(check: Callable[[Any], None]) -> Callable[[], None]:
        def test() -> None:
            faults = []
            for name in names:
                try:
                    check(name)
                except AssertionError as fault:
                    faults.append(f"{name}: {fault}")
            assert not faults, "\n".join(faults)

        return test

    return decorate


@of_each(FILES)
def test_packages_import_only_what_they_may(module: str) -> None:
    package = module.split(".")[0]
    ours = {target.split(".")[0] for target, _ in imports(tree_of(module))} & {*PACKAGES, "tests"}
    assert ours <= {package} | MAY_IMPORT[package]


@of_each(FLOORS)
def test_inside_a_folder_imports_follow_the_way_of_the_data(folder: str) -> None:
    floor = {name: i for i, rooms in enumerate(FLOORS[folder]) for name in rooms}
    depth = folder.count(".") + 1
    inside = {name.split(".")[depth] for name in FILES if name.startswith(f"{folder}.")}
    assert inside == set(floor)
    for module in FILES:
        if not module.startswith(f"{folder}."):
            continue
        room = module.split(".")[depth]
        for target, name in imports(tree_of(module)):
            if not begins(target, folder):
                continue
            other = str(name) if target == folder else target.split(".")[depth]
            assert other == room or floor[other] < floor[room], f"{module} imports {target}"


def test_the_folder_of_the_commands_shows_them_and_what_they_share_in_one_room() -> None:
    inside = {name.split(".")[2] for name in FILES if name.startswith("pipeline.commands.")}
    assert inside == {*COMMANDS, "interaction"}


@of_each(FILES)
def test_each_dependency_is_imported_only_at_its_home(module: str) -> None:
    for target, _ in imports(tree_of(module)):
        top = target.split(".")[0]
        if top in PACKAGES or top in sys.stdlib_module_names:
            continue
        assert top in HOME, f"{module} imports {top}, which is no dependency of the project"
        assert any(begins(module, home) for home in HOME[top]), f"{module} imports {top}"


@of_each(FILES)
def test_nothing_private_is_imported_from_another_module(module: str) -> None:
    for target, name in imports(tree_of(module)):
        assert not (name or "").startswith("_"), f"{module}: from {target} import {name}"


@of_each(TEST_FILES)
def test_what_tests_share_stands_in_modules_that_are_no_tests_and_no_benches(module: str) -> None:
    for target, name in imports(tree_of(module)):
        rooms = (*target.split("."), name or "")
        if rooms[0] != "tests":
            continue
        assert not any(room.startswith("test_") for room in rooms), f"{module} imports {target}"
        assert rooms[1] != "bench" or begins(module, "tests.bench"), f"{module} imports {target}"


def test_the_declared_dependencies_are_those_with_a_home() -> None:
    distribution = {"cv2": "opencv-python-headless", "serial": "pyserial", "yaml": "pyyaml"}
    declared = {each.split(">")[0] for each in PROJECT["project"]["dependencies"]}
    known = {distribution.get(name, name) for name in HOME} - {"pydantic_core", *EXTRAS}
    assert declared == known
    optional = PROJECT["project"]["optional-dependencies"]
    assert {name: [extra for extra, each in optional.items() if extra not in ("test", "logs")
                   and name in {one.split(">")[0] for one in each}] for name in EXTRAS} == {
        name: [extra] for name, extra in EXTRAS.items()}


def test_modules_import_each_other_without_circles() -> None:
    graph = {}
    for module, tree in ((name, tree_of(name)) for name in FILES):
        at_import = ast.Module([node for node in tree.body
                                if isinstance(node, ast.Import | ast.ImportFrom)], [])
        graph[module] = {
            f"{target}.{name}" if f"{target}.{name}" in FILES else target
            for target, name in imports(at_import)
        } & FILES.keys()
    TopologicalSorter(graph).prepare()  # raises CycleError, which names the circle


def test_every_folder_with_code_is_a_package_that_is_installed() -> None:
    folders = {module_name(path) for path in FILES.values() if path.name == "__init__.py"}
    with_code = {module_name(path.parent / "__init__.py") for path in FILES.values()}
    assert with_code == folders, "a folder with code has no __init__.py"
    found = PROJECT["tool"]["setuptools"]["packages"]["find"]["include"]
    assert {pattern.rstrip("*") for pattern in found} == set(PACKAGES)


def test_the_top_level_holds_what_it_should_and_no_more() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True,
                            check=False)
    if listed.returncode:
        pytest.skip("this is not a git checkout")
    top = {line.split("/")[0] for line in listed.stdout.splitlines()}
    allowed = {*PACKAGES, "tests", "data", "pyproject.toml", "README.md"}
    assert {name for name in top if not name.startswith(".")} <= allowed


@of_each([*FILES.values(), *TEST_FILES.values()])
def test_files_are_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST_FILE


@of_each(FILES)
def test_everything_public_says_what_it_is(module: str) -> None:
    tree = tree_of(module)
    assert ast.get_docstring(tree), "the module has no docstring"
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            if any(ast.unparse(decorator) == "overload" for decorator in node.decorator_list):
                continue  # a type of the function that follows
            assert ast.get_docstring(node), node.name
            for child in node.body if isinstance(node, ast.ClassDef) else ():
                if isinstance(child, ast.FunctionDef) and not child.name.startswith("_"):
                    assert ast.get_docstring(child), f"{node.name}.{child.name}"


def test_a_module_binds_a_constant_once() -> None:
    """A second one of the same name, as of files put together, would change what uses the first."""
    twice = []
    for module in FILES:
        names = [name.id for node in tree_of(module).body if isinstance(node, ast.Assign)
                 for target in node.targets for name in ast.walk(target)
                 if isinstance(name, ast.Name)]
        twice += [f"{module}.{name}" for name in set(names) if names.count(name) > 1]
    assert twice == []


def test_a_class_name_occurs_once() -> None:
    homes: dict[str, list[str]] = {}
    for module, tree in ((name, tree_of(name)) for name in FILES):
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                homes.setdefault(node.name, []).append(module)
    assert {name: modules for name, modules in homes.items() if len(modules) > 1} == {}


def test_a_public_function_s_name_means_one_thing() -> None:
    homes: dict[str, list[str]] = {}
    for module in FILES:
        for node in tree_of(module).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, []).append(module)
    assert {name: modules for name, modules in homes.items()
            if len(modules) > 1 and name not in ONE_THING} == {}


@of_each(FILES)
def test_results_are_called_by_what_they_are(module: str) -> None:
    """Variables, fields and loop targets; a parameter is the caller's and no result."""
    bound = {(node.lineno, node.id if isinstance(node, ast.Name) else node.attr)
             for node in ast.walk(tree_of(module))
             if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store)}
    assert {(line, name) for line, name in bound if name in NO_RESULTS} == set()


@of_each(FILES)
def test_no_catch_all_no_eval_no_drawer_for_everything(module: str) -> None:
    assert module.split(".")[-1] not in {"util", "utils", "helpers", "common", "misc"}
    for node in ast.walk(tree_of(module)):
        if isinstance(node, ast.ExceptHandler):
            caught = ast.unparse(node.type) if node.type else "everything"
            assert caught not in {"everything", "Exception", "BaseException"}, node.lineno
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in {"eval", "exec"}, node.lineno


def undocumented_numbers(module: str) -> Iterator[str]:
    """Upper-case constants made of numbers that no docstring and no comment describes."""
    lines = FILES[module].read_text(encoding="utf-8").splitlines()
    body = tree_of(module).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        name = ast.unparse(target).strip("()")
        values = [each.value for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
        is_number = any(type(value) in (int, float) for value in values)
        if not name.isupper() or name.startswith("_") or not is_number or any(
                isinstance(value, str) for value in values):
            continue
        is_described = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        beside = lines[node.lineno - 2 : node.end_lineno]
        if not (is_described or any("#" in line for line in beside[1:])
                or beside[0].startswith("#")):
            yield f"{module}:{node.lineno}: {name}"


@of_each(FILES)
def test_a_constant_says_what_it_is_and_where_it_comes_from(module: str) -> None:
    """By a docstring below it or a comment beside it; thresholds may stand in a frozen record."""
    assert list(undocumented_numbers(module)) == []

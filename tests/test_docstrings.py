"""What docstrings must state: shapes and units of arrays, errors of other rooms, true examples."""

import ast
import doctest
import importlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

from tests.source_tree import FILES, imports, tree_of

ERRORS = ("calib.errors", "pipeline.errors", "vision.errors")
Function = tuple[str, str]  #: module and name


def room(module: str) -> str:
    """``calib.fit`` of ``calib.fit.rows.residuals``."""
    return ".".join(module.split(".")[:2])


def classes(module: str) -> Iterator[tuple[str, set[str]]]:
    """The classes of a module, each with the names of its bases."""
    for node in tree_of(module).body:
        if isinstance(node, ast.ClassDef):
            yield node.name, {ast.unparse(base).split(".")[-1] for base in node.bases}


BASES = {name: bases for module in ERRORS for name, bases in classes(module) if bases}


@cache
def with_bases(error: str) -> frozenset[str]:
    """An error and all that catch it."""
    return frozenset({error}).union(*map(with_bases, BASES.get(error, ())))


@dataclass(frozen=True)
class Body:
    """What a function raises itself, and whom it calls, each with the errors caught around it."""

    raised: frozenset[tuple[str, frozenset[str]]]
    called: frozenset[tuple[Function, frozenset[str]]]


def names_in(node: ast.AST) -> frozenset[str]:
    """All names and attributes of an expression."""
    return frozenset(each.id if isinstance(each, ast.Name) else each.attr for each in ast.walk(node)
                     if isinstance(each, ast.Name | ast.Attribute))


def guarded(function: ast.FunctionDef) -> Iterator[tuple[ast.AST, frozenset[str]]]:
    """Every node of a function with the errors that are caught around it."""
    waiting: list[tuple[ast.AST, frozenset[str]]] = [(function, frozenset())]
    while waiting:
        node, caught = waiting.pop()
        yield node, caught
        inside = caught
        if isinstance(node, ast.Try):
            inside |= frozenset().union(*(names_in(handler.type) for handler in node.handlers
                                          if handler.type is not None))
        elif isinstance(node, ast.With):
            contexts = [names_in(item.context_expr) for item in node.items]
            inside |= frozenset().union(*(names for names in contexts if "suppress" in names))
        body = {id(child) for child in getattr(node, "body", ())} if inside is not caught else ()
        waiting += [(child, inside if id(child) in body else caught)
                    for child in ast.iter_child_nodes(node)]


@cache
def origins(module: str) -> dict[str, str]:
    """From where a module has the names that it imports from our packages."""
    return {name: target for target, name in imports(tree_of(module)) if name and target in FILES}


def body_of(module: str, function: ast.FunctionDef) -> Body:
    """The errors of a function; a name that was imported means the function there."""
    raised, called = set(), set()
    for node, caught in guarded(function):
        if isinstance(node, ast.Raise) and node.exc is not None:
            raised |= {(name, caught) for name in names_in(node.exc) & BASES.keys()}
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            called.add(((origins(module).get(node.func.id, module), node.func.id), caught))
    return Body(frozenset(raised), frozenset(called))


def errors_of_all() -> dict[Function, set[str]]:
    """The errors that leave every function, those of the functions it calls included."""
    bodies = {(module, node.name): body_of(module, node) for module in FILES
              for node in tree_of(module).body if isinstance(node, ast.FunctionDef)}
    errors: dict[Function, set[str]] = {
        function: {name for name, caught in body.raised if not with_bases(name) & caught}
        for function, body in bodies.items()
    }
    is_settled = False
    while not is_settled:
        is_settled = True
        for function, body in bodies.items():
            more = {name for other, caught in body.called for name in errors.get(other, ())
                    if not with_bases(name) & caught}
            if not more <= errors[function]:
                errors[function] |= more
                is_settled = False
    return errors


def test_what_another_room_calls_states_the_errors_that_it_raises() -> None:
    shared = {(target, str(name)) for module in FILES for target, name in imports(tree_of(module))
              if target in FILES and room(target) != room(module)}
    silent = []
    for (module, name), errors in errors_of_all().items():
        if (module, name) not in shared:
            continue
        function = next(node for node in reversed(tree_of(module).body)  # behind its overloads
                        if isinstance(node, ast.FunctionDef) and node.name == name)
        stated = ast.get_docstring(function) or ""
        silent += [f"{module}.{name}: {error}" for error in sorted(errors)
                   if not any(each in stated for each in with_bases(error))]
    assert silent == []


def test_an_error_that_is_caught_does_not_count() -> None:
    source = """
def outer():
    try:
        raise UnusableLog("x")
    except CalibrationError:
        pass
    raise FitFailed("y")
"""
    function = ast.parse(source).body[0]
    assert isinstance(function, ast.FunctionDef)
    left = {name for name, caught in body_of("calib.errors", function).raised
            if not with_bases(name) & caught}
    assert left == {"FitFailed"}


def test_examples_give_what_they_show() -> None:
    shown = [module for module, path in FILES.items() if ">>>" in path.read_text(encoding="utf-8")]
    results = {module: doctest.testmod(importlib.import_module(module)) for module in shown}
    assert sum(result.attempted for result in results.values()) > 0
    assert {module: result.failed for module, result in results.items() if result.failed} == {}


# --- shapes of arrays -----------------------------------------------------------------------------

#: A result of this type, or the first of several, is an array; ``Strips`` and ``Spectra`` state
#: their shapes where they are defined.
ARRAY = re.compile(r"(tuple\[)?(\w*Array|NDArray\[.*\]|np\.ndarray|Luma|Image|Keys|Integers)\b")
#: ``(n, 3)``, ``(k,)``, ``(≤ most,)``, ``(...,)``
SHAPE = re.compile(r"\([^(),]+,([^(),]+(,[^(),]+)*)?\)|shape \(")


def is_catalogued(function: ast.FunctionDef) -> bool:
    """Columns of an effect: (n, 3, k) or (n, k) by what its decorator states, with their units."""
    return any(isinstance(each, ast.Call) for each in function.decorator_list)


def public_functions(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    """Public functions of a module and of its public classes."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public_functions(node.body)
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node


def gives_an_array_of_unstated_shape(function: ast.FunctionDef) -> bool:
    result = ast.unparse(function.returns) if function.returns else ""
    return (ARRAY.match(result) is not None and not is_catalogued(function)
            and SHAPE.search(ast.get_docstring(function) or "") is None)


def test_what_gives_an_array_states_its_shape() -> None:
    silent = [f"{module}.{function.name}" for module in FILES
              for function in public_functions(tree_of(module).body)
              if gives_an_array_of_unstated_shape(function)]
    assert silent == []


def test_a_shape_is_told_from_another_bracket() -> None:
    source = """
def silent(x: FloatArray) -> FloatArray:
    '''Half of x (which may be negative), or (where it is) less.'''

def stated(x: FloatArray) -> tuple[FloatArray, float]:
    '''Half of x, (n, 3), rad.'''
"""
    silent, stated = public_functions(ast.parse(source).body)
    assert gives_an_array_of_unstated_shape(silent)
    assert not gives_an_array_of_unstated_shape(stated)


# --- units of arrays ------------------------------------------------------------------------------

#: Masks, indices, numbers of poses, levels of grey: what is in them has no unit by its type.
COUNTED = re.compile(r"(tuple\[)?(BoolArray|IntArray|Keys|Luma|Image|np\.ndarray|"
                     r"NDArray\[(Any|np\.(bool_|intp|int64|uint8))\])")
#: A name says its unit as everywhere in the project: ``sd_rad``, ``repaired_time_s``.
UNIT_IN_NAME = re.compile(r"_(rad_s|m_s2|rad|px|deg|ppm|rpm|s|m)$")
#: A unit of the field; one that the caller chose; or that there is none.
UNIT = re.compile(
    r"rad/s|m/s²|°|(, | in )s(?=[,.;:)])|\b(rad|radians|seconds|px|[Pp]ixels|[Cc]ounts|SI)\b|"
    r"\b[Pp]late radi(us|i)\b|\bframe times\b|\b[Ww]hitened\b|\b[Ii]n (their |its )?sds\b|"
    r"\b([Aa]ny|[Ii]n (its|their|the same)|per|square of (its|their)) units?\b|"
    r"\bunit squared\b|\b([Nn]o|[Ww]ithout a) unit\b")
#: What has no unit wherever it is met.
PURE = re.compile(r"\b([Uu]nit vectors?|[Rr]otation|[Oo]rthonormal|[Ss]hare|[Cc]orrelation|"
                  r"[Ll]og (density|densities|prior)|[Ii]ndices)\b")
SECTION = re.compile(r"\n(\w[\w ]*)\n-+\n")
RETURNED = re.compile(r"^(\w+) : ", re.MULTILINE)


def said_of_the_result(docstring: str) -> str:
    """The text of a numpydoc docstring without what it says of parameters, errors and examples."""
    text, *sections = SECTION.split("\n" + docstring)
    return text + "".join(each for name, each in zip(sections[::2], sections[1::2], strict=True)
                          if name == "Returns")


def gives_an_array_of_unstated_unit(function: ast.FunctionDef) -> bool:
    result = ast.unparse(function.returns) if function.returns else ""
    if ARRAY.match(result) is None or is_catalogued(function) or COUNTED.match(result):
        return False
    said = said_of_the_result(ast.get_docstring(function) or "")
    names = [function.name, *RETURNED.findall(said)]
    return not (any(map(UNIT_IN_NAME.search, names)) or UNIT.search(said) or PURE.search(said))


def test_what_gives_an_array_states_its_unit_or_that_it_has_none() -> None:
    silent = [f"{module}.{function.name}" for module in FILES
              for function in public_functions(tree_of(module).body)
              if gives_an_array_of_unstated_unit(function)]
    assert silent == []


def test_a_unit_is_told_from_other_words() -> None:
    source = """
def silent(x: FloatArray) -> FloatArray:
    '''How fast it turns, (n,); the sds are units of their own, s a name.'''

def of_another(x: FloatArray) -> FloatArray:
    '''How fast it turns.

    Parameters
    ----------
    x : array, shape (n,)
        Angles, rad.

    Returns
    -------
    array, shape (n,)
    '''

def stated(x: FloatArray) -> FloatArray:
    '''How fast it turns, (n,), rad/s.'''

def named_s(x: FloatArray) -> FloatArray:
    '''When it turns, (n,).'''

def pure(x: FloatArray) -> FloatArray:
    '''Unit vectors (n, 3) of its axis.'''

def mask(x: FloatArray) -> BoolArray:
    '''Whether it turns, (n,).'''
"""
    found = [gives_an_array_of_unstated_unit(each) for each in public_functions(
        ast.parse(source).body)]
    assert found == [True, True, False, False, False, False]


NO_NOUN = re.compile(r"(of|that|those|by|as)\b", re.IGNORECASE)
"""Beginning of a docstring without the noun that it is about."""


def docstrings(module: str) -> Iterator[tuple[str, str]]:
    """Every docstring of a module and of its constants, and every comment that stands for one."""
    for node in ast.walk(tree_of(module)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield getattr(node, "name", module), ast.get_docstring(node) or ""
        body = getattr(node, "body", ())
        for before, after in pairwise(body if isinstance(body, list) else ()):
            if isinstance(before, ast.Assign | ast.AnnAssign) and isinstance(after, ast.Expr):
                yield ast.unparse(before), ast.unparse(after.value).strip("'\"")
    lines = FILES[module].read_text(encoding="utf-8").splitlines()
    for before, line in pairwise(["", *lines]):
        if "#: " in line and not before.lstrip().startswith("#: "):
            code, _, comment = line.partition("#: ")
            yield code or comment, comment


def test_a_docstring_begins_with_what_it_is_about() -> None:
    """With a noun or a verb; a constant's names its quantity: "Share of ...", "Number of ..."."""
    telegrams = [f"{module} {name}: {text[:60]}" for module in FILES
                 for name, text in docstrings(module) if NO_NOUN.match(text)]
    assert telegrams == []

"""Small changes of the program's own code, one at a time: the operators of mutation testing.

The operators are those of mutmut and cosmic-ray that change what is computed: other arithmetic,
comparisons, logic, numbers, truth values, signs, branches, loops that end otherwise, calls left
out, min for max. Words, types, decorators and the messages of errors stay as they are.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.MatMult: ast.Mult,
}  # fmt: skip
COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt), ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,), ast.NotIn: (ast.In,),
}  # fmt: skip
NAMES = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all",
    "all": "any", "argmin": "argmax", "argmax": "argmin", "floor": "ceil", "ceil": "floor",
    "fmin": "fmax", "fmax": "fmin",
}  # fmt: skip
TRUE_CODE = -1
"""In the place of a change's number: none is made."""
WIDEST = 90
"""Characters of a piece of code that a change is told by."""


@dataclass(frozen=True, slots=True)
class Change:
    """Change number `number` of `module` (its path in the tree).

    `compiled` says that it may stand in compiled code, which only a run without the compiler sees.
    """

    module: str
    number: int
    line: int
    where: str
    what: str
    compiled: bool


@dataclass(frozen=True, slots=True)
class _Site:
    """A node, where its parent holds it, what may stand there instead, and which constants it is
    a part of."""

    parent: ast.AST
    field: str
    place: int | None
    other: ast.AST
    where: str
    compiled: bool
    assigns: frozenset[str]

    @property
    def node(self) -> ast.AST:
        held = getattr(self.parent, self.field)
        return held if self.place is None else held[self.place]  # type: ignore[no-any-return]


def changes_of(module: str, source: str, in_kernels: Set[str] = frozenset()) -> list[Change]:
    """All changes of a module; of its constants those of these names stand in compiled code."""
    return [
        Change(
            module,
            k,
            getattr(site.node, "lineno", 0),
            site.where,
            f"{_short(site.node)} → {_short(site.other)}",
            site.compiled or not in_kernels.isdisjoint(site.assigns),
        )
        for k, site in enumerate(_sites(ast.parse(source)))
    ]


def names_in_kernels(sources: Iterable[str]) -> set[str]:
    """The names that kernels of these modules read, and those that such constants are made of."""
    found: set[str] = set()
    constants: list[ast.Assign] = []
    for source in sources:
        for node in ast.parse(source).body:
            if isinstance(node, ast.FunctionDef) and _is_kernel(node):
                found |= _names(node)
            elif isinstance(node, ast.Assign):
                constants.append(node)
    more = found
    while more:
        used = [one for one in constants if not _names(*one.targets).isdisjoint(more)]
        more = _names(*(one.value for one in used)) - found
        found |= more
    return found


def _is_kernel(function: ast.FunctionDef) -> bool:
    return any("kernel" in ast.unparse(one) for one in function.decorator_list)


def _names(*nodes: ast.AST) -> set[str]:
    return {one.id for node in nodes for one in ast.walk(node) if isinstance(one, ast.Name)}


def changed(source: str, number: int) -> ast.Module:
    """The module with that change made."""
    tree = ast.parse(source)
    for k, site in enumerate(_sites(tree)):
        if k == number:
            if site.place is None:
                setattr(site.parent, site.field, site.other)
            else:
                getattr(site.parent, site.field)[site.place] = site.other
            return tree
    raise IndexError(number)


def _short(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= WIDEST else text[: WIDEST - 1] + "…"


def _sites(tree: ast.Module) -> Iterator[_Site]:
    yield from _within(tree, "", compiled=False)


def _within(
    parent: ast.AST, where: str, assigns: frozenset[str] = frozenset(), *, compiled: bool
) -> Iterator[_Site]:
    if isinstance(parent, ast.FunctionDef):
        where = f"{where}.{parent.name}" if where else parent.name
        compiled = compiled or _is_kernel(parent)
    elif isinstance(parent, ast.Assign) and not where:
        assigns = frozenset(_names(*parent.targets))
    elif isinstance(parent, ast.ClassDef):
        where = f"{where}.{parent.name}" if where else parent.name
    for field, value in ast.iter_fields(parent):
        if field in {"annotation", "returns", "decorator_list", "format_spec"}:
            continue
        for place, node in enumerate(value) if isinstance(value, list) else ((None, value),):
            if not isinstance(node, ast.AST) or isinstance(node, ast.Raise) or _only_checks(node):
                continue
            for other in _others(node, parent):
                whole = ast.fix_missing_locations(ast.copy_location(other, node))
                yield _Site(parent, field, place, whole, where, compiled, assigns)
            yield from _within(node, where, assigns, compiled=compiled)


def _only_checks(node: ast.AST) -> bool:
    """Whether a node is for readers and type checkers alone."""
    match node:
        case ast.Assert() | ast.Import() | ast.ImportFrom():
            return True
        case ast.If(test=ast.Name("TYPE_CHECKING")):
            return True
        case ast.Call(func=ast.Name("cast" | "isinstance")):
            return True
        case ast.Assign(value=ast.BinOp(op=ast.BitOr())):  # a union of types
            return True
    return False


def _others(node: Any, parent: ast.AST) -> Iterator[ast.AST]:
    match node:
        case ast.BinOp(op=op) | ast.AugAssign(op=op) if type(op) in ARITHMETIC:
            yield _with(node, op=ARITHMETIC[type(op)]())
        case ast.Compare(ops=ops):
            for k, op in enumerate(ops):
                for other in COMPARISONS[type(op)]:
                    yield _with(node, ops=[*ops[:k], other(), *ops[k + 1 :]])
        case ast.BoolOp(op=op):
            yield _with(node, op=ast.Or() if isinstance(op, ast.And) else ast.And())
        case ast.UnaryOp(op=ast.USub() | ast.Not() | ast.Invert(), operand=operand):
            yield operand
        case ast.Constant(value=bool() as truth):
            yield ast.Constant(not truth)
        case ast.Constant(value=int() | float() as number):
            yield ast.Constant(number + 1)
    yield from _other_ways(node, parent)


def _other_ways(node: Any, parent: ast.AST) -> Iterator[ast.AST]:
    """Statements and branches that are left out or turned, and functions that are others."""
    match node:
        case ast.Break():
            yield ast.Continue()
        case ast.Continue():
            yield ast.Break()
        case ast.Expr(value=ast.Call()):
            yield ast.Pass()
        case ast.AugAssign(target=target, value=value):
            yield ast.Assign([target], value)
        case ast.Name(id=name) if name in NAMES and isinstance(parent, ast.Call):
            yield ast.Name(NAMES[name], ast.Load())
        case ast.Attribute(attr=name) if name in NAMES and isinstance(parent, ast.Call):
            yield _with(node, attr=NAMES[name])
        case ast.Compare() | ast.BoolOp() | ast.UnaryOp():
            return  # has its turned forms
    if isinstance(parent, ast.If | ast.IfExp) and parent.test is node:
        yield ast.UnaryOp(ast.Not(), node)


def _with(node: ast.AST, **fields: object) -> ast.AST:
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other


def modules_under(root: Path, folder: str) -> list[str]:
    """The modules of a folder of the tree."""
    return sorted(str(file.relative_to(root)) for file in (root / folder).rglob("*.py"))

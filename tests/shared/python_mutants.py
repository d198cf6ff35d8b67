"""Mutants of a Python module: the module with one operator, number or function changed."""

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

#: Each operator, number or function is replaced by its neighbour.
_OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_PAIRS = (
    ("min", "max"),
    ("minimum", "maximum"),
    ("fmin", "fmax"),
    ("argmin", "argmax"),
    ("any", "all"),
    ("sin", "cos"),
)
_FUNCTIONS = {name: other for pair in _PAIRS for name, other in (pair, pair[::-1])}

#: A number beyond it is doubled: one more would be no change worth a test.
LARGE = 15


@dataclass(frozen=True)
class Mutant:
    """A changed file: what was changed in which line, and what makes its text.

    Attributes
    ----------
    path : str
    line : int
        Number of the line, from 1.
    source : str
        The line before the change, without blanks around it.
    change : str
    text : callable
    """

    path: str
    line: int
    source: str
    change: str
    text: Callable[[], str]

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.change}"


def python_mutants(root: Path, path: str) -> Iterator[Mutant]:
    """All mutants of a module, in the order of its lines."""
    text = (root / path).read_text(encoding="utf-8")
    lines = ["", *text.splitlines()]
    for number, (node, field, index, new) in enumerate(_places(ast.parse(text))):
        changed = copy.deepcopy(node)
        _write(changed, field, index, new)
        words = f"{ast.unparse(node)} -> {ast.unparse(changed)}"
        line = getattr(node, "lineno", 0)
        yield Mutant(path, line, lines[line].strip(), words, partial(_changed, text, number))


def _changed(text: str, number: int) -> str:
    """The text of a module with one change."""
    tree = ast.parse(text)
    _write(*next(islice(_places(tree), number, None)))
    return ast.unparse(tree)


_Change = tuple[ast.AST, str, int | None, object]


def _places(tree: ast.AST) -> Iterator[_Change]:
    """Node, field, index in a list of the field, and its new value. Annotations are left alone."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _places(child)
    match tree:
        case ast.BinOp(op=op) | ast.AugAssign(op=op) | ast.BoolOp(op=op) if type(op) in _OPERATORS:
            yield tree, "op", None, _OPERATORS[type(op)]()
        case ast.Compare(ops=ops):
            for index, sign in enumerate(ops):
                yield tree, "ops", index, _OPERATORS[type(sign)]()
        case ast.UnaryOp(op=ast.Not()) | ast.UnaryOp(op=ast.USub()):
            yield tree, "op", None, ast.UAdd() if isinstance(tree.op, ast.USub) else None
        case ast.Constant(value=bool() as truth):
            yield tree, "value", None, not truth
        case ast.Constant(value=int() | float() as number):
            yield tree, "value", None, 2 * number if abs(number) > LARGE else number + 1
        case ast.Attribute(attr=name) if name in _FUNCTIONS:
            yield tree, "attr", None, _FUNCTIONS[name]
        case ast.Call(func=ast.Name(id=name)) if name in _FUNCTIONS:
            yield tree, "func", None, ast.Name(_FUNCTIONS[name], ast.Load())


def _write(node: ast.AST, field: str, index: int | None, new: object) -> None:
    if index is not None:
        getattr(node, field)[index] = new
    elif new is None:
        # `not x` becomes `x` as a truth value.
        assert isinstance(node, ast.UnaryOp)
        node.operand = ast.UnaryOp(ast.Not(), node.operand)
    else:
        setattr(node, field, new)

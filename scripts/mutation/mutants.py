"""Making mutants: every operator, comparison, constant, order and statement of a source, changed one at a time."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple


class Mutant(NamedTuple):
    """One change: where and what."""

    name: str
    """Function, what was there and what is there now; a number where the same is found more than once."""
    parent: ast.AST
    field: str
    place: int | None
    """In the field, where that is a list."""
    change: ast.AST
    function: str
    """Where it stands; empty in a module's own statements."""
    line: int
    """Of the statement that it is in; 0 outside of functions, where everything runs on import."""

    def apply(self) -> None:
        """Put the change into the tree that the mutant was made from."""
        if self.place is None:
            setattr(self.parent, self.field, self.change)
        else:
            getattr(self.parent, self.field)[self.place] = self.change


COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Everything that is done to one node, each as a new node in its place."""
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            for other in COMPARISONS[type(operator)]:
                yield ast.Compare(node.left, [*node.ops[:i], other(), *node.ops[i + 1 :]], node.comparators)
    elif isinstance(node, ast.BinOp):
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
    elif isinstance(node, ast.AugAssign):
        yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)
        yield ast.Pass()
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.And() if isinstance(node.op, ast.Or) else ast.Or(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub | ast.Invert):
        yield node.operand
    elif isinstance(node, ast.Constant):
        value = node.value
        if isinstance(value, bool):
            yield ast.Constant(not value)
        elif isinstance(value, int | float):
            yield ast.Constant(value + 1)
            yield ast.Constant(value - 1)
        elif isinstance(value, str) and value[:1] in ("<", ">") and len(value) > 1:
            yield ast.Constant("<>"["><".index(value[0])] + value[1:])  # the byte order of a struct
        elif isinstance(value, str) and value:
            yield ast.Constant(value + "?")
        elif isinstance(value, bytes) and value:
            yield ast.Constant(bytes((value[0] ^ 1,)) + value[1:])
    elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield ast.Return(ast.Constant(None))
    elif _is_call(node) or (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute)):
        yield ast.Pass()
    elif isinstance(node, ast.Continue):
        yield ast.Break()
    elif isinstance(node, ast.Break):
        yield ast.Continue()


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)


class Site(NamedTuple):
    """A place in a tree, and where it stands in the source."""

    parent: ast.AST
    field: str
    place: int | None
    function: str
    line: int

    @property
    def node(self) -> ast.AST:
        """What is there now."""
        found = getattr(self.parent, self.field)
        return found if self.place is None else found[self.place]


def sites(tree: ast.Module) -> Iterator[Site]:
    """Where a change is possible. What only people read is left."""

    def walk(node: ast.AST, function: str, line: int, inside: bool) -> Iterator[Site]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            function = f"{function}.{node.name}" if function else node.name
        if isinstance(node, ast.Raise | ast.JoinedStr):
            return  # the words of a refusal
        if isinstance(node, ast.keyword) and node.arg == "about":
            return  # what a DBC says to people
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("__slots__", "__all__"):
            return
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "bases"):
                continue
            runs_later = inside or _is_body(node, field)
            for i, child in enumerate(value) if isinstance(value, list) else ((None, value),):
                if not isinstance(child, ast.AST) or _is_docstring(child):
                    continue
                its_line = child.lineno if runs_later and isinstance(child, ast.stmt) else line
                yield Site(node, field, i, function, its_line)
                yield from walk(child, function, its_line, runs_later)

    return walk(tree, "", 0, False)


def _is_body(node: ast.AST, field: str) -> bool:
    """Of a function: what does not run on import."""
    return isinstance(node, ast.FunctionDef) and field == "body"


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def marked(source: str, mark: str) -> ast.Module:
    """The tree in which every statement of a function first calls `mark` with its line."""
    tree = ast.parse(source)

    def walk(node: ast.AST, inside: bool) -> None:
        for field, value in ast.iter_fields(node):
            runs_later = inside or _is_body(node, field)
            children = value if isinstance(value, list) else [value]
            for child in children:
                if isinstance(child, ast.AST):
                    walk(child, runs_later)
            if runs_later and isinstance(value, list):
                value[:] = [one for child in value for one in with_mark(child)]

    def with_mark(node: ast.AST) -> list[ast.AST]:
        if not isinstance(node, ast.stmt) or _is_docstring(node):
            return [node]
        call = ast.Call(ast.Name(mark, ast.Load()), [ast.Constant(node.lineno)], [])
        return [ast.copy_location(ast.Expr(call), node), node]

    walk(tree, False)
    return ast.fix_missing_locations(tree)


def mutants(source: str) -> tuple[ast.Module, list[Mutant]]:
    """The tree, and all that can be done to it, in the order of the source."""
    tree = ast.parse(source)
    made: list[Mutant] = []
    seen: Counter[str] = Counter()
    for site in list(sites(tree)):
        for change in changes(site.node):
            name = f"{site.function or 'module'}: {_text(site.node)} -> {_text(change)}"
            seen[name] += 1
            if seen[name] > 1:
                name += f" #{seen[name]}"
            made.append(Mutant(name, site.parent, site.field, site.place, change, site.function, site.line))
    return tree, made


def _text(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= 100 else text[:97] + "..."

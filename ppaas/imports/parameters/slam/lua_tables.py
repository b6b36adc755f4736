"""Tables of a Lua file that sets options, without executing it.

Assignments of constants, tables and other options are read, and so is arithmetic with them. Everything else is reported
as computed.
"""

import math
import operator
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.ros_yaml import MAX_DEPTH, GivenValue
from ppaas.imports.report import ImportReport

MAX_LUA = 1 << 17
"""Limit of the size of a Lua file [bytes]: its parser takes about a second for it."""


class LuaTables(msgspec.Struct, frozen=True):
    """What a Lua file sets.

    Parameters
    ----------
    values : dict
        Values by their dotted paths: ``TRAJECTORY_BUILDER_2D.max_range``.
    included : list of (str, int)
        Files that it includes, with their lines.
    """

    values: dict[str, GivenValue]
    included: list[tuple[str, int]]


def read_lua_tables(content: bytes, aliases: Mapping[str, str], report: ImportReport) -> LuaTables:
    """Read the tables of a Lua file; what is computed in another way than by arithmetic is reported as refused.

    Parameters
    ----------
    content : bytes
    aliases : mapping of str to str
        Paths that are other names of a table.
    report : ImportReport
        It is changed.

    Raises
    ------
    InvalidParameter
        The file is not in Lua, too large, or nested too deeply.
    """
    from luaparser import ast  # noqa: PLC0415 - of the extra imports

    if len(content) > MAX_LUA:
        raise InvalidParameter(f"the Lua file has {len(content)} bytes; at most {MAX_LUA} are allowed")
    try:
        text = content.decode("utf-8-sig")
        _check_depth(text)
        tree = ast.parse(text)
    except UnicodeDecodeError as error:
        raise InvalidParameter(f"the Lua file is not in UTF-8: {error}") from error
    except (ast.SyntaxException, RecursionError) as error:
        raise InvalidParameter(f"the file is not in Lua: {' '.join(str(error).split())}") from error
    reader = _Reader(aliases, report)
    for statement in tree.body.body:
        reader.read(statement)
    return LuaTables(reader.values, reader.included)


def _check_depth(text: str) -> None:
    """Refuse a text that opens more brackets than it closes by more than `MAX_DEPTH`, wherever they are."""
    depth = 0
    for character in text:
        depth += (character in "{(") - (character in "})")
        if depth > MAX_DEPTH:
            raise InvalidParameter(f"the Lua file is nested more than {MAX_DEPTH} deep")


class _ComputedError(Exception):
    """A value is computed; the text says how."""


_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "AddOp": operator.add, "SubOp": operator.sub, "MultOp": operator.mul, "FloatDivOp": operator.truediv,
    "ExpoOp": operator.pow,
}  # fmt: skip

_FUNCTIONS: dict[str, Callable[[float], float]] = {"math.rad": math.radians, "math.deg": math.degrees}
_CONSTANTS = {"math.pi": math.pi, "math.huge": math.inf}
_CONSTANT_OF: dict[str, Callable[[Any], Any]] = {
    "TrueExpr": lambda _: True,
    "FalseExpr": lambda _: False,
    "Number": lambda node: node.n,
    "String": lambda node: str(_text(node)),
}
"""Functions that return the value of a constant."""


class _Reader:
    """Reads the statements of a Lua file in order.

    Parameters
    ----------
    aliases : mapping of str to str
    report : ImportReport
    """

    def __init__(self, aliases: Mapping[str, str], report: ImportReport) -> None:
        self.values: dict[str, GivenValue] = {}
        self.included: list[tuple[str, int]] = []
        self._aliases = {f"{path}.": f"{table}." for path, table in aliases.items()}
        self._report = report

    def read(self, statement: Any) -> None:
        """Read one statement."""
        kind, line = type(statement).__name__, _line(statement)
        if kind in ("Assign", "LocalAssign") and len(statement.targets) == len(statement.values):
            for target, value in zip(statement.targets, statement.values, strict=True):
                self._assign(_path(target), value, line)
        elif kind == "Call" and _path(statement.func) in ("include", "require", "dofile") and statement.args:
            self.included.append((_text(statement.args[0]), line))
        elif kind not in ("Return", "SemiColon", "Comment"):
            words = "only assignments of values are read; write what it sets"
            self._report.refused(f"line {line}", f"{kind.lower()}: {words}", line)

    def _assign(self, path: str, value: Any, line: int) -> None:
        if not path:
            self._report.refused(f"line {line}", "the name of what is set is computed; write it out", line)
            return
        canonical = self._canonical(path)
        for name in [name for name in self.values if name == canonical or name.startswith(f"{canonical}.")]:
            del self.values[name]
        self._set(canonical, value, line)

    def _set(self, path: str, value: Any, line: int) -> None:
        """Set the value of a path, or the values below it."""
        if type(value).__name__ == "Table" and any(_key(field) for field in value.fields):
            for field in value.fields:
                self._set_field(path, field)
            return
        named = _path(value)
        if named and self._canonical(named) == path:  # options.map_builder = MAP_BUILDER
            return
        below = self._below(self._canonical(named)) if named else {}
        if below:
            self.values |= {f"{path}{rest}": GivenValue(given.value, line) for rest, given in below.items()}
            return
        try:
            self.values[path] = GivenValue(self._value(value), line)
        except _ComputedError as error:
            self._report.refused(path, f"{error}; write the value itself", line)

    def _set_field(self, path: str, field: Any) -> None:
        name, line = _key(field), _line(field)
        if name:
            self._set(self._canonical(f"{path}.{name}"), field.value, line)
        else:
            self._report.refused(path, "a list is mixed with names", line)

    def _value(self, node: Any) -> Any:
        kind = type(node).__name__
        constant = _CONSTANT_OF.get(kind)
        if constant is not None:
            return constant(node)
        if kind == "Table":
            return [self._value(field.value) for field in node.fields]
        if kind == "UMinusOp":
            return -self._number(node.operand)
        if kind in _OPERATORS:
            return self._computed(node)
        return self._named(node)

    def _named(self, node: Any) -> Any:
        """Return the value of a name, or of a function that converts angles."""
        if type(node).__name__ == "Call" and _path(node.func) in _FUNCTIONS and len(node.args) == 1:
            return _FUNCTIONS[_path(node.func)](self._number(node.args[0]))
        path = _path(node)
        if path in _CONSTANTS:
            return _CONSTANTS[path]
        given = self.values.get(self._canonical(path)) if path else None
        if given is None:
            raise _ComputedError(f"{path!r} is not set in this file" if path else "it is computed")
        return given.value

    def _computed(self, node: Any) -> float:
        try:
            found = _OPERATORS[type(node).__name__](self._number(node.left), self._number(node.right))
        except (ArithmeticError, ValueError) as error:
            raise _ComputedError(f"it cannot be computed: {error}") from error
        if isinstance(found, complex):
            raise _ComputedError("it is no real number")
        return float(found)

    def _number(self, node: Any) -> float:
        value = self._value(node)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _ComputedError(f"{value!r} is no number")
        return float(value)

    def _canonical(self, path: str) -> str:
        """Return a path by the name of the table that it is in."""
        full = f"{path}."
        for alias in (*self._aliases, *self._aliases):  # a table may be in another one that has another name
            if full.startswith(alias):
                full = self._aliases[alias] + full[len(alias) :]
        return full[:-1]

    def _below(self, path: str) -> dict[str, GivenValue]:
        """Return the values below a path, by the rest of their paths."""
        return {name[len(path) :]: given for name, given in self.values.items() if name.startswith(f"{path}.")}


def _path(node: Any) -> str:
    """Return the dotted path of a name or an index by names; empty for anything else."""
    return ".".join(reversed([*_steps(node)])) if _is_path(node) else ""


def _is_path(node: Any) -> bool:
    while type(node).__name__ == "Index":
        if type(node.idx).__name__ not in ("Name", "String"):
            return False
        node = node.value
    return type(node).__name__ == "Name"


def _steps(node: Any) -> Iterator[str]:
    while type(node).__name__ == "Index":
        yield _text(node.idx)
        node = node.value
    yield node.id


def _key(field: Any) -> str:
    """Return the name of a field of a table; empty for an element of a list."""
    return _text(field.key) if type(field.key).__name__ in ("Name", "String") else ""


def _text(node: Any) -> str:
    found = getattr(node, "id", None) or getattr(node, "s", "")
    return found.decode() if isinstance(found, bytes) else str(found)


def _line(node: Any) -> int:
    return int(getattr(node, "line", 0) or 0)

"""ROS parameters of one robot by their global names: those that its nodes were made with, and free ones.

A name is a path; what is above others is their namespace, and reads as an object of them, as in ROS 1.
"""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from ppaas.errors import InvalidParameter, NotFound, QuotaExceeded

MAX_NAME = 255
MAX_DEPTH = 16
MAX_FREE = 500
"""Names of free parameters of one robot."""

MAX_FREE_BYTES = 32 << 10
"""Of all free parameters of one robot together, as JSON: they are part of each of its checkpoints."""

_NAME = re.compile(r"/?(?:[A-Za-z_][\w.-]*(?:/[A-Za-z_][\w.-]*)*)?/?", re.ASCII)
_INT64 = range(-(2**63), 2**63)


def path_of(name: str) -> tuple[str, ...]:
    """Return a name's parts; ``/node:name``, as ROS 2's rosapi has it, is ``/node/name``.

    Raises
    ------
    InvalidParameter
        It is no name.
    """
    name = name.replace(":", "/", 1)
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise InvalidParameter(f"not a parameter's name: {name[:64]!r}; write it as /node/name")
    path = tuple(part for part in name.split("/") if part)
    if len(path) > MAX_DEPTH:
        raise InvalidParameter(f"a parameter's name has at most {MAX_DEPTH} parts, not {len(path)}")
    return path


def read_value(text: str) -> Any:
    """Return the value that a parameter is to have.

    Raises
    ------
    InvalidParameter
        Not JSON; or null, a number that is not finite or an integer of more than 64 bits anywhere in it; or too deep.
    """
    if len(text) > MAX_FREE_BYTES:
        raise InvalidParameter(f"a value has at most {MAX_FREE_BYTES} bytes")
    try:
        value = msgspec.json.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InvalidParameter(f"a parameter's value is given as JSON: {error}") from error
    _check(value, MAX_DEPTH)
    return value


def _check(value: Any, depth: int) -> None:
    if depth < 0:
        raise InvalidParameter(f"a value has at most {MAX_DEPTH} levels")
    match value:
        case dict():
            for inner in value.values():
                _check(inner, depth - 1)
        case list():
            for inner in value:
                _check(inner, depth - 1)
        case bool() | str():
            pass
        case int() if value in _INT64:
            pass
        case float() if math.isfinite(value):
            pass
        case _:
            raise InvalidParameter(f"{value!r:.40} is no value of a parameter: they are finite, and not null")


def _leaves(path: tuple[str, ...], value: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield what an object sets, name by name; an empty object is itself a value."""
    if not isinstance(value, dict) or not value:
        yield path, value
        return
    for key, inner in value.items():
        if len(path_of(key)) != 1:
            raise InvalidParameter(f"{key!r:.64} within {_shown(path)} is no name of a parameter")
        yield from _leaves((*path, key), inner)


def _shown(path: tuple[str, ...]) -> str:
    return "/" + "/".join(path)


class ParameterTree:
    """Parameters by name.

    Parameters
    ----------
    own : dict of dict
        Each node's parameters by its name, as they are in use; these can be read alone.
    """

    def __init__(self, own: Mapping[str, Mapping[str, Any]]) -> None:
        self._own = {(node, name): value for node, values in own.items() for name, value in values.items()}
        self._nodes = frozenset(own)
        self._free: dict[tuple[str, ...], Any] = {}

    def names(self) -> list[str]:
        """Return the names of all parameters, sorted."""
        return sorted(map(_shown, (*self._own, *self._free)))

    def get(self, name: str) -> Any:
        """Return the value of a parameter, or an object of all within a namespace.

        Raises
        ------
        NotFound
            There is none of that name.
        InvalidParameter
            It is no name.
        """
        path = path_of(name)
        found: dict[str, Any] = {}
        for key, value in (*self._own.items(), *self._free.items()):
            if key == path:
                return value
            if key[: len(path)] == path:
                _put(found, key[len(path) :], value)
        if not found and path:
            near = [known for known in self.names() if known.startswith(_shown(path[:1]) + "/")]
            raise NotFound("parameter", _shown(path), near)
        return found

    def has(self, name: str) -> bool:
        """Tell whether there is a parameter or a namespace of that name.

        Raises
        ------
        InvalidParameter
            It is no name.
        """
        path = path_of(name)
        return any(key[: len(path)] == path for key in (*self._own, *self._free))

    def set(self, name: str, value: Any) -> None:
        """Set a free parameter, or several by an object; what was within that name before is gone.

        Raises
        ------
        InvalidParameter
            It is a node's, who reads it only when it is made, or the node has none of that name.
        QuotaExceeded
            Too many, or too much.
        """
        path = path_of(name)
        leaves = dict(_leaves(path, value))
        for leaf, wanted in leaves.items():
            self._check_free(leaf, wanted)
        free = {key: old for key, old in self._free.items() if not _overlap(key, path)}
        free |= {leaf: new for leaf, new in leaves.items() if leaf not in self._own}
        if len(free) > MAX_FREE or len(_encode(free)) > MAX_FREE_BYTES:
            raise QuotaExceeded(
                f"a robot has at most {MAX_FREE} parameters of its own, of {MAX_FREE_BYTES} bytes in all"
            )
        self._free = free

    def _check_free(self, path: tuple[str, ...], value: Any) -> None:
        if not path:
            raise InvalidParameter("the root of all parameters is no parameter: write /name or /node/name")
        if path in self._own and self._own[path] == value:
            return
        if path[0] in self._nodes:
            known = [_shown(own) for own in self._own if own[0] == path[0]]
            if path[:2] in self._own or len(path) == 1:
                raise InvalidParameter(_fixed(path))
            raise InvalidParameter(f"{path[0]!r} has no parameter {_shown(path)}; known: {', '.join(sorted(known))}")

    def delete(self, name: str) -> None:
        """Delete a free parameter, or all within a namespace.

        Raises
        ------
        NotFound
            There is none.
        InvalidParameter
            A node needs it.
        """
        path = path_of(name)
        if any(key[: len(path)] == path for key in self._own):
            raise InvalidParameter(_fixed(path))
        kept = {key: value for key, value in self._free.items() if key[: len(path)] != path}
        if len(kept) == len(self._free):
            raise NotFound("parameter", _shown(path))
        self._free = kept

    def search(self, name: str) -> str:
        """Return the global name of a parameter that is looked for from the root, empty if there is none."""
        path = path_of(name)
        return _shown(path) if path and self.has(name) else ""

    def free(self) -> bytes:
        """Return the free parameters as JSON, for ``restore``."""
        return _encode(self._free)

    def restore(self, free: bytes) -> None:
        """Take what ``free`` returned."""
        self._free = {tuple(name.split("/")[1:]): value for name, value in msgspec.json.decode(free).items()}


def _encode(parameters: dict[tuple[str, ...], Any]) -> bytes:
    return msgspec.json.encode({_shown(path): value for path, value in parameters.items()})


def _overlap(one: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Tell whether one is the other, or within it."""
    return all(a == b for a, b in zip(one, other, strict=False))


def _put(tree: dict[str, Any], path: tuple[str, ...], value: Any) -> None:
    *spaces, last = path
    for space in spaces:
        tree = tree.setdefault(space, {})
    tree[last] = value


def _fixed(path: tuple[str, ...]) -> str:
    return (
        f"{_shown(path)} is read when the robot's clone is made: set it in the robot's file (ppaas robot put), under "
        f'"parameters", and connect anew'
    )

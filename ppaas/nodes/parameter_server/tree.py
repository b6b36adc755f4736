"""ROS parameters of one robot by their global names: read-only ones of its nodes, and free ones of its clients.

A name is a path. As in ROS 1, a prefix of it is a namespace, whose value is an object of the parameters in it.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec

from ppaas.errors import InvalidParameter, NotFound, QuotaExceeded, listed

MAX_NAME = 255
"""Longest name [characters]."""

MAX_DEPTH = 16
"""Largest number of parts of a name, and of levels of a value."""

MAX_FREE = 500
"""Largest number of free parameters of one robot."""

MAX_FREE_BYTES = 32 << 10
"""Limit of all free parameters of one robot as JSON, since each checkpoint contains them [bytes]."""

_NAME = re.compile(r"/?(?:[A-Za-z_][\w.-]*(?:/[A-Za-z_][\w.-]*)*)?/?", re.ASCII)
_INT64 = range(-(2**63), 2**63)


def path_of(name: str) -> tuple[str, ...]:
    """Return the parts of a name; ``/node:name``, the form of ROS 2's rosapi, is read as ``/node/name``.

    Raises
    ------
    InvalidParameter
        The name is invalid.
    """
    name = name.replace(":", "/", 1)
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise InvalidParameter(f"invalid parameter name {name[:64]!r}; write it as /node/name")
    path = tuple(part for part in name.split("/") if part)
    if len(path) > MAX_DEPTH:
        raise InvalidParameter(f"a parameter name must have at most {MAX_DEPTH} parts, not {len(path)}")
    return path


def read_value(text: str) -> Any:
    """Return the value of a parameter from JSON.

    Raises
    ------
    InvalidParameter
        The text is not JSON, is nested too deeply, or contains null, a number that is not finite, or an integer of
        more than 64 bits.
    """
    if len(text) > MAX_FREE_BYTES:
        raise InvalidParameter(f"a parameter value must have at most {MAX_FREE_BYTES} bytes")
    try:
        value = msgspec.json.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InvalidParameter(f"a parameter value must be JSON: {error}") from error
    _check(value, MAX_DEPTH)
    return value


def _check(value: Any, depth: int) -> None:
    if depth < 0:
        raise InvalidParameter(f"a parameter value must have at most {MAX_DEPTH} levels")
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
            raise InvalidParameter(f"{value!r:.40} is not a valid parameter value: null and non-finite are not allowed")


def _leaves(path: tuple[str, ...], value: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the names and values that an object sets; an empty object is a value itself."""
    if not isinstance(value, dict) or not value:
        yield path, value
        return
    for key, inner in value.items():
        if len(path_of(key)) != 1:
            raise InvalidParameter(f"{key!r:.64} in {_shown(path)} is not a valid parameter name")
        yield from _leaves((*path, key), inner)


def _shown(path: tuple[str, ...]) -> str:
    return "/" + "/".join(path)


class ParameterTree:
    """Parameters of one robot by name.

    Parameters
    ----------
    own : dict of dict
        Parameters in use by each node, by its name; they are read-only.
    large : mapping, optional
        Functions that return the values of further parameters, by the parts of their names. Objects of namespaces do
        not contain them. Those that are not of a node are defaults: clients may set other values.
    """

    def __init__(
        self,
        own: Mapping[str, Mapping[str, Any]],
        large: Mapping[tuple[str, ...], Callable[[], Any]] | None = None,
    ) -> None:
        self._own = {(node, name): value for node, values in own.items() for name, value in values.items()}
        self._large = dict(large or {})
        self._nodes = frozenset(own)
        self._free: dict[tuple[str, ...], Any] = {}

    def names(self) -> list[str]:
        """Return the names of all parameters, sorted."""
        return sorted(map(_shown, {*self._own, *self._large, *self._free}))

    def get(self, name: str) -> Any:
        """Return the value of a parameter, or an object of all parameters in a namespace.

        Raises
        ------
        NotFound
            There is no parameter or namespace of that name.
        InvalidParameter
            The name is invalid.
        """
        path = path_of(name)
        if path in self._large and path not in self._free:
            return self._large[path]()
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
        """Return whether there is a parameter or namespace of that name.

        Raises
        ------
        InvalidParameter
            The name is invalid.
        """
        path = path_of(name)
        return any(key[: len(path)] == path for key in (*self._own, *self._large, *self._free))

    def set(self, name: str, value: Any) -> None:
        """Set a free parameter, or several by an object, which replaces the whole namespace.

        Raises
        ------
        InvalidParameter
            The parameter is a node's and therefore read-only, or the node has no such parameter.
        QuotaExceeded
            There would be too many free parameters, or too many bytes of them.
        """
        path = path_of(name)
        leaves = dict(_leaves(path, value))
        for leaf, wanted in leaves.items():
            self._check_free(leaf, wanted)
        free = {key: old for key, old in self._free.items() if not _overlap(key, path)}
        free |= {leaf: new for leaf, new in leaves.items() if leaf not in self._own}
        if len(free) > MAX_FREE or len(_encode(free)) > MAX_FREE_BYTES:
            raise QuotaExceeded(
                f"a robot may have at most {MAX_FREE} free parameters, of {MAX_FREE_BYTES} bytes in all"
            )
        self._free = free

    def _check_free(self, path: tuple[str, ...], value: Any) -> None:
        if not path:
            raise InvalidParameter("'/' is not a parameter: write /name or /node/name")
        if path in self._own and self._own[path] == value:
            return
        if path[0] in self._nodes:
            known = [_shown(own) for own in self._own if own[0] == path[0]]
            if path[:2] in self._own or path in self._large or len(path) == 1:
                raise InvalidParameter(_fixed(path))
            raise InvalidParameter(f"{path[0]!r} has no parameter {_shown(path)}; known: {listed(sorted(known))}")

    def delete(self, name: str) -> None:
        """Delete a free parameter, or all in a namespace.

        Raises
        ------
        NotFound
            There is no such parameter.
        InvalidParameter
            The parameter is a node's and therefore read-only.
        """
        path = path_of(name)
        fixed = (*self._own, *(key for key in self._large if key[0] in self._nodes))
        if any(key[: len(path)] == path for key in fixed):
            raise InvalidParameter(_fixed(path))
        kept = {key: value for key, value in self._free.items() if key[: len(path)] != path}
        if len(kept) == len(self._free):
            raise NotFound("parameter", _shown(path))
        self._free = kept

    def search(self, name: str) -> str:
        """Return the global name of a parameter, searched from the root; empty if there is none."""
        path = path_of(name)
        return _shown(path) if path and self.has(name) else ""

    def free(self) -> bytes:
        """Return the free parameters as JSON, for ``restore``."""
        return _encode(self._free)

    def restore(self, free: bytes) -> None:
        """Set the free parameters from the result of ``free``."""
        self._free = {tuple(name.split("/")[1:]): value for name, value in msgspec.json.decode(free).items()}


def _encode(parameters: dict[tuple[str, ...], Any]) -> bytes:
    return msgspec.json.encode({_shown(path): value for path, value in parameters.items()})


def _overlap(one: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Return whether two names are equal, or one is a namespace of the other."""
    return all(a == b for a, b in zip(one, other, strict=False))


def _put(tree: dict[str, Any], path: tuple[str, ...], value: Any) -> None:
    *spaces, last = path
    for space in spaces:
        tree = tree.setdefault(space, {})
    tree[last] = value


def _fixed(path: tuple[str, ...]) -> str:
    return (
        f"{_shown(path)} is read only when the robot's clone is created: set it in the robot's file (ppaas robot put), "
        f'under "parameters", and reconnect'
    )

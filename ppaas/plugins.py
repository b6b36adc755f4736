"""Plug-ins by entry point: planners and controllers, ours and other people's, found the same way.

What is installed runs with all that its process may do. So a process of a cloud loads of other people's only what an
administrator has allowed (``permit_only``); on one's own computer nobody is asked.
"""

from collections.abc import Iterable
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from inspect import Parameter, signature
from typing import Any, Generic, TypeVar

import msgspec

from ppaas.errors import InvalidParameter, NotFound, NotPermitted

P = TypeVar("P")

OWN = "ppaas"
"""The distribution whose plug-ins come with us."""

_permitted: frozenset[str] | None = None


def permit_only(allowed: Iterable[str]) -> None:
    """Let this process, from now on, load no plug-ins but our own and those that are named.

    Parameters
    ----------
    allowed : iterable of str
        Each as ``group:name`` of its entry point, such as ``ppaas.planners:mine``.

    Raises
    ------
    InvalidParameter
        One is not spelled so.
    """
    global _permitted  # noqa: PLW0603 - it is a property of the process
    names = frozenset(allowed)
    for name in names:
        group, _, plugin = name.partition(":")
        if not (group.startswith(f"{OWN}.") and plugin):
            raise InvalidParameter(f"a plug-in is named as group:name, such as ppaas.planners:mine, not {name!r}")
    _permitted = names


def permitted() -> tuple[str, ...] | None:
    """Return what other people's plug-ins this process may load, by name; None if it may load all."""
    return None if _permitted is None else tuple(sorted(_permitted))


def _is_own(entry: EntryPoint) -> bool:
    return entry.dist is not None and entry.dist.name == OWN


def _may_load(entry: EntryPoint) -> bool:
    return _permitted is None or _is_own(entry) or f"{entry.group}:{entry.name}" in _permitted


def parameters_in_use(of: object) -> dict[str, Any]:
    """Return the parameters of a node or a plug-in by name, defaults included.

    Parameters
    ----------
    of : object
        A struct or a dataclass of parameters; or a plug-in that has such ``parameters``, or that keeps what its class
        takes as attributes of the same names.
    """
    parameters = getattr(of, "parameters", of)
    if isinstance(parameters, msgspec.Struct) or hasattr(parameters, "__dataclass_fields__"):
        told: dict[str, Any] = msgspec.to_builtins(parameters)
        return told
    return {name: getattr(of, name) for name in signature(type(of)).parameters if hasattr(of, name)}


def read_keywords(what: str, plugin: type, given: dict[str, Any]) -> dict[str, Any]:
    """Return what a plug-in's constructor is to be called with, checked by name and type.

    A constructor that takes a record of parameters (``**parameters``) checks them itself.

    Parameters
    ----------
    what : str
        Who is meant, for the error.
    plugin : type
        Its class.
    given : dict
        Parameters by name, as JSON has them: 1 will do as a float, a list as a tuple.

    Raises
    ------
    InvalidParameter
        One is unknown or of another type; the text names those there are.
    """
    taken = signature(plugin, eval_str=True).parameters
    if any(each.kind is Parameter.VAR_KEYWORD for each in taken.values()):
        return given
    read = {}
    for name, value in given.items():
        if name not in taken:
            raise InvalidParameter(f"{what} takes no parameter {name!r}; known: {', '.join(sorted(taken)) or 'none'}")
        kind = taken[name].annotation
        try:
            read[name] = value if kind is Parameter.empty else msgspec.convert(value, kind)
        except msgspec.ValidationError as error:
            raise InvalidParameter(f"parameter {name!r} of {what}: {error}") from error
    return read


class PluginRegistry(Generic[P]):
    """The plug-ins of one entry point group; nothing is imported before it is asked for.

    Parameters
    ----------
    group : str
        Entry point group, such as ``ppaas.planners``.
    kind : str
        What one is called in an error.
    base : type
        What each must subclass.
    aliases : dict of str to str
        Other names, such as those of ROS, of plug-ins that come with us.
    """

    def __init__(self, group: str, kind: str, base: type[P], aliases: dict[str, str]) -> None:
        self._group = group
        self._kind = kind
        self._base = base
        self._aliases = aliases

    @cached_property
    def _entries(self) -> dict[str, EntryPoint]:
        # Nobody takes the place of one of ours by its name.
        return {entry.name: entry for entry in sorted(entry_points(group=self._group), key=_is_own)}

    def names(self) -> tuple[str, ...]:
        """Return the names of all plug-ins that are installed and allowed, sorted."""
        return tuple(sorted(name for name, entry in self._entries.items() if _may_load(entry)))

    def own_name(self, name: str) -> str:
        """Return the own name of a plug-in that is given by its name or an alias, in either spelling of ROS 2."""
        return self._aliases.get(name, self._aliases.get(name.replace("::", "/"), name))

    def aliases(self, name: str) -> tuple[str, ...]:
        """Return the aliases of one plug-in."""
        own = self.own_name(name)
        return tuple(alias for alias, target in self._aliases.items() if target == own)

    def spellings(self, name: str) -> tuple[str, ...]:
        """Return every name of one plug-in: its own, and its aliases whole and without their package."""
        aliases = self.aliases(name)
        return self.own_name(name), *aliases, *(alias.rpartition("/")[2] for alias in aliases)

    def load(self, name: str) -> type[P]:
        """Return the class of a plug-in by its name or alias.

        Raises
        ------
        NotFound
            None of that name; the text lists those there are.
        NotPermitted
            It is installed, and no administrator has allowed it.
        """
        entry = self._entries.get(self.own_name(name))
        if entry is None:
            raise NotFound(self._kind, name, self.names())
        if not _may_load(entry):
            how = f"ppaas up --allow {self._group}:{entry.name}"
            raise NotPermitted(f"{self._kind} {name!r} is installed, but no administrator has allowed it; {how}")
        loaded = entry.load()
        if not (isinstance(loaded, type) and issubclass(loaded, self._base)):
            raise InvalidParameter(f"{entry.value} is no {self._base.__name__}, as entry point {name!r} says it is")
        return loaded

    def create(self, name: str, parameters: dict[str, Any]) -> P:
        """Make a plug-in.

        Raises
        ------
        NotFound
            None of that name.
        NotPermitted
            No administrator has allowed it.
        InvalidParameter
            It takes no such parameter, or none of that type.
        """
        plugin = self.load(name)
        keywords = read_keywords(f"{self._kind} {name!r}", plugin, parameters)
        try:
            return plugin(**keywords)
        except TypeError as error:
            raise InvalidParameter(f"{self._kind} {name!r}: {error}") from error

"""Plug-ins by entry point: planners, controllers and recoveries of this and of other distributions.

A plug-in runs with all rights of its process. A process of the cloud therefore loads only those plug-ins of other
distributions that an administrator has allowed (``permit_only``); without that call, all installed plug-ins load.
"""

from collections.abc import Iterable
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from inspect import Parameter, signature
from typing import Any, Generic, TypeVar

import msgspec

from ppaas.decoding import converted
from ppaas.distribution import BrokenPlugin, is_own, load_entry, origin
from ppaas.errors import InvalidParameter, NotFound, NotPermitted, PPaaSError

P_co = TypeVar("P_co", covariant=True)

GROUPS = "ppaas."
"""Beginning of the names of the entry point groups of plug-ins."""

_permitted: frozenset[str] | None = None


def permit_only(allowed: Iterable[str]) -> None:
    """Restrict this process, from now on, to the project's own plug-ins and the given ones.

    Parameters
    ----------
    allowed : iterable of str
        Plug-ins as ``group:name`` of their entry points, such as ``ppaas.planners:mine``.

    Raises
    ------
    InvalidParameter
        A name has another form.
    """
    global _permitted  # noqa: PLW0603 - it is a property of the process
    names = frozenset(allowed)
    for name in names:
        group, _, plugin = name.partition(":")
        if not (group.startswith(GROUPS) and plugin):
            raise InvalidParameter(f"name a plug-in as group:name, for example ppaas.planners:mine, not {name!r}")
    _permitted = names


def permitted() -> tuple[str, ...] | None:
    """Return the names of the plug-ins of other distributions that this process may load; None if it may load all."""
    return None if _permitted is None else tuple(sorted(_permitted))


def _may_load(entry: EntryPoint) -> bool:
    return _permitted is None or is_own(entry) or f"{entry.group}:{entry.name}" in _permitted


def parameters_in_use(of: object) -> dict[str, Any]:
    """Return the parameters of a node or a plug-in by name, including defaults.

    Parameters
    ----------
    of : object
        A struct or a dataclass of parameters; or a plug-in that has one as ``parameters``, or that stores its
        constructor's arguments as attributes of the same names.
    """
    parameters = getattr(of, "parameters", of)
    if isinstance(parameters, msgspec.Struct) or hasattr(parameters, "__dataclass_fields__"):
        values: dict[str, Any] = msgspec.to_builtins(parameters)
        return values
    return {name: getattr(of, name) for name in signature(type(of)).parameters if hasattr(of, name)}


def read_keywords(what: str, plugin: type, given: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of a plug-in's constructor, checked by name and type.

    A constructor with ``**parameters`` gets them unchecked, and checks them itself.

    Parameters
    ----------
    what : str
        Description of the plug-in, for the error, such as ``planner 'mine'``.
    plugin : type
        Class of the plug-in.
    given : dict
        Parameters by name, decoded from JSON: 1 is accepted as a float, a list as a tuple.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or of another type; the text lists the known names.
    """
    taken = signature(plugin, eval_str=True).parameters
    if any(each.kind is Parameter.VAR_KEYWORD for each in taken.values()):
        return given
    read = {}
    for name, value in given.items():
        if name not in taken:
            raise InvalidParameter(f"{what} has no parameter {name!r}; known: {', '.join(sorted(taken)) or 'none'}")
        kind = taken[name].annotation
        try:
            read[name] = value if kind is Parameter.empty else converted(value, kind)
        except msgspec.ValidationError as error:
            raise InvalidParameter(f"parameter {name!r} of {what}: {error}") from error
    return read


def taken_by(plugin: type, offered: dict[str, Any]) -> dict[str, Any]:
    """Return those of the offered arguments that a plug-in's constructor takes; all if it has ``**parameters``."""
    taken = signature(plugin).parameters
    if any(each.kind is Parameter.VAR_KEYWORD for each in taken.values()):
        return offered
    return {name: value for name, value in offered.items() if name in taken}


class PluginRegistry(Generic[P_co]):
    """Plug-ins of one entry point group; a plug-in is imported when it is first loaded.

    Parameters
    ----------
    group : str
        Entry point group, such as ``ppaas.planners``.
    kind : str
        Noun for a plug-in in errors, such as ``planner``.
    base : type
        Base class of all plug-ins of the group.
    aliases : dict of str to str
        Alias to own name, for plug-ins of this distribution: the names that they have in ROS.
    """

    def __init__(self, group: str, kind: str, base: type[P_co], aliases: dict[str, str]) -> None:
        self._group = group
        self._kind = kind
        self._base = base
        self._aliases = aliases

    @cached_property
    def _entries(self) -> dict[str, EntryPoint]:
        # Own entry points come last, so that no other distribution replaces one of them by using its name.
        return {entry.name: entry for entry in sorted(entry_points(group=self._group), key=is_own)}

    def __contains__(self, name: str) -> bool:
        """Return whether a plug-in is installed, by its name or an alias; it may not be allowed."""
        return self.own_name(name) in self._entries

    def names(self) -> tuple[str, ...]:
        """Return the sorted names of all plug-ins that are installed and allowed."""
        return tuple(sorted(name for name, entry in self._entries.items() if _may_load(entry)))

    def own_name(self, name: str) -> str:
        """Return the own name of a plug-in given by its name or an alias, with ``/`` or ``::`` after the package."""
        return self._aliases.get(name, self._aliases.get(name.replace("::", "/"), name))

    def full_name(self, name: str) -> str:
        """Return how an administrator allows a plug-in: ``group:name``, with its own name."""
        return f"{self._group}:{self.own_name(name)}"

    def aliases(self, name: str) -> tuple[str, ...]:
        """Return the aliases of one plug-in."""
        own = self.own_name(name)
        return tuple(alias for alias, target in self._aliases.items() if target == own)

    def spellings(self, name: str) -> tuple[str, ...]:
        """Return all names of one plug-in: its own name, and its aliases with and without their package."""
        aliases = self.aliases(name)
        return self.own_name(name), *aliases, *(alias.rpartition("/")[2] for alias in aliases)

    def load(self, name: str) -> type[P_co]:
        """Return the class of a plug-in by its name or alias.

        Raises
        ------
        NotFound
            No plug-in has that name; the text lists the names.
        NotPermitted
            The plug-in is installed, but no administrator has allowed it.
        BrokenPlugin
            It cannot be imported, or its entry point does not refer to a subclass of the group's base class; the text
            names the distribution and the entry point.
        """
        entry = self._entries.get(self.own_name(name))
        if entry is None:
            raise NotFound(self._kind, name, self.names())
        if not _may_load(entry):
            command = f"ppaas up --allow {self.full_name(name)}"
            raise NotPermitted(f"{self._kind} {name!r} is installed, but not allowed; allow it with: {command}")
        loaded = load_entry(entry, self._kind)
        if not (isinstance(loaded, type) and issubclass(loaded, self._base)):
            raise BrokenPlugin(f"{self._kind} {name!r} ({origin(entry)}) is not a subclass of {self._base.__name__}")
        return loaded

    def create(self, name: str, parameters: dict[str, Any]) -> P_co:
        """Create a plug-in.

        Raises
        ------
        NotFound
            No plug-in has that name.
        NotPermitted
            No administrator has allowed it.
        InvalidParameter
            A parameter is unknown, of the wrong type or refused by the plug-in.
        BrokenPlugin
            It cannot be loaded, or its constructor fails in another way.
        """
        plugin = self.load(name)
        keywords = read_keywords(f"{self._kind} {name!r}", plugin, parameters)
        try:
            return plugin(**keywords)
        except (TypeError, ValueError) as error:
            raise InvalidParameter(f"{self._kind} {name!r}: {error}") from error
        except PPaaSError:
            raise
        except Exception as error:
            entry = self._entries[self.own_name(name)]
            if is_own(entry):
                raise
            text = f"{self._kind} {name!r} ({origin(entry)}) cannot be created: {type(error).__name__}: {error}"
            raise BrokenPlugin(text) from error

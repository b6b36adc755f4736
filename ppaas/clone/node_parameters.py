"""Parameters of a clone's nodes and plug-ins, as given by its user and as in use."""

from collections.abc import Mapping
from typing import Any, TypeVar

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters
from ppaas.plugins import parameters_in_use

P = TypeVar("P", bound=Parameters)


class NodeParameters:
    """Parameters by the name of their node or plug-in; unknown names are rejected.

    Attributes
    ----------
    given : mapping
        All of them, as their user gave them.
    in_use : dict of dict
        Parameters in use, including defaults, by the same names.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.given = parameters
        self.in_use: dict[str, dict[str, Any]] = {}
        self._rest = dict(parameters)
        self._asked: list[str] = []

    def read(self, cls: type[P], node: str, defaults: Mapping[str, Any] | None = None) -> P:
        """Return the parameters of a node, and record them as in use."""
        parameters = read_parameters(cls, node, {**(defaults or {}), **self.take(node)})
        self.note(node, parameters)
        return parameters

    def check(self, cls: type[P], node: str) -> None:
        """Check the parameters of a node that this clone does not have; they are not in use."""
        read_parameters(cls, node, self.take(node))

    def note(self, name: str, of: object) -> None:
        """Record the parameters that a node or plug-in uses."""
        self.in_use[name] = parameters_in_use(of)

    def has(self, *names: str) -> bool:
        """Return whether there are parameters under one of these names."""
        return not self._rest.keys().isdisjoint(names)

    def take(self, *names: str) -> dict[str, Any]:
        """Remove and return the parameters under these names, which belong to one node or plug-in."""
        self._asked.append(names[0])
        merged: dict[str, Any] = {}
        for name in names:
            merged |= self._table(name)
        return merged

    def _table(self, name: str) -> dict[str, Any]:
        table = self._rest.pop(name, {})
        if not isinstance(table, dict):
            raise InvalidParameter(f"parameters of {name!r} must be an object, not {table!r}")
        return table

    def refuse_rest(self) -> None:
        """Raise ``InvalidParameter`` if parameters remain that no node or plug-in has taken."""
        if self._rest:
            raise InvalidParameter(
                f"parameters for unknown node {sorted(self._rest)[0]!r}; known: {', '.join(sorted(self._asked))}"
            )

"""Resources of the REST service on the command line: each kind is listed, shown, changed and deleted alike."""

import argparse
import json
from dataclasses import dataclass
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.session import logged_in
from robots.client.rest_paths import path_of


@dataclass(frozen=True, slots=True)
class Resource:
    """A kind of resource of the REST service.

    Parameters
    ----------
    name : str
        As in its path: ``"robots"``.
    columns : tuple of str
        What people see of one.
    none : str
        What they are told where there is none.
    list_columns : tuple of str, optional
        What they see of each in a list, if that is not the same.
    """

    name: str
    columns: tuple[str, ...]
    none: str
    list_columns: tuple[str, ...] = ()

    async def list(self, arguments: argparse.Namespace) -> None:
        """List all, or as many as ``--limit`` says."""
        found = await logged_in(arguments).items(path_of(self.name), arguments.limit)
        show(found, self.list_columns or self.columns, as_json=arguments.json, if_none=self.none)

    async def show(self, arguments: argparse.Namespace) -> None:
        """Show the one of an id."""
        one = await logged_in(arguments).get(path_of(self.name, arguments.id))
        show(one, self.columns, as_json=arguments.json)

    async def delete(self, arguments: argparse.Namespace) -> None:
        """Delete the one of an id."""
        await logged_in(arguments).delete(path_of(self.name, arguments.id))


def merge_patch(changes: list[str]) -> dict[str, Any]:
    """Return the JSON merge patch (RFC 7396) of ``NAME=VALUE`` texts; dots in a name lead into objects.

    A value is JSON, or if it is none, text.

    Raises
    ------
    InvalidInput
        A text that has no name, or names what another has given a value already; a number that is not finite.
    """
    patch: dict[str, Any] = {}
    for text in changes:
        name, equals, value = text.partition("=")
        *way, last = name.split(".")
        inner: Any = patch
        for step in way:
            inner = inner.setdefault(step, {}) if isinstance(inner, dict) else None
        if not equals or "" in (*way, last) or not isinstance(inner, dict) or last in inner:
            raise InvalidInput(f"{text!a}: write NAME=VALUE, as cores=0.5, and each name once")
        inner[last] = _value(value)
    try:
        json.dumps(patch, allow_nan=False)
    except ValueError as error:  # they would go as null, which is something else
        raise InvalidInput("a number must be finite") from error
    return patch


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text

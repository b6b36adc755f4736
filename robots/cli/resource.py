"""Resources of the REST service on the command line: the verbs that all kinds share."""

import argparse
import json
from dataclasses import dataclass
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.session import logged_in
from robots.client.cloud_url import path_of


@dataclass(frozen=True, slots=True)
class Resource:
    """A kind of resource of the REST service.

    Parameters
    ----------
    name : str
        Name in the path, as ``"robots"``.
    columns : tuple of str
        Columns of the table for one.
    none : str
        Text that replaces the table of an empty list.
    list_columns : tuple of str, optional
        Columns of the table of a list, if different.
    """

    name: str
    columns: tuple[str, ...]
    none: str
    list_columns: tuple[str, ...] = ()

    async def list(self, arguments: argparse.Namespace) -> None:
        """List all resources, or the first ``--limit``."""
        found = await logged_in(arguments).items(path_of(self.name), arguments.limit)
        show(found, self.list_columns or self.columns, as_json=arguments.json, if_none=self.none)

    async def show(self, arguments: argparse.Namespace) -> None:
        """Show the resource with an id."""
        one = await logged_in(arguments).get(path_of(self.name, arguments.id))
        show(one, self.columns, as_json=arguments.json)

    async def delete(self, arguments: argparse.Namespace) -> None:
        """Delete the resource with an id."""
        await logged_in(arguments).delete(path_of(self.name, arguments.id))


def merge_patch(changes: list[str]) -> dict[str, Any]:
    """Return the JSON merge patch (RFC 7396) of ``NAME=VALUE`` arguments; dots in a name separate nested keys.

    A value that is not JSON is taken as a string.

    Raises
    ------
    InvalidInput
        An argument has no name or repeats one, or a number is not finite.
    """
    patch: dict[str, Any] = {}
    for text in changes:
        name, equals, value = text.partition("=")
        *parents, last = name.split(".")
        inner: Any = patch
        for step in parents:
            inner = inner.setdefault(step, {}) if isinstance(inner, dict) else None
        if not equals or "" in (*parents, last) or not isinstance(inner, dict) or last in inner:
            raise InvalidInput(f"{text!a} is not a valid change; write NAME=VALUE, as cores=0.5, and each name once")
        inner[last] = _value(value)
    try:
        json.dumps(patch, allow_nan=False)
    except ValueError as error:  # JSON would turn them into null, which means the default
        raise InvalidInput("numbers must be finite") from error
    return patch


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text

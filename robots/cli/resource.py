"""What commands do alike with each kind of resource: list, show and delete it."""

import argparse
from dataclasses import dataclass

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

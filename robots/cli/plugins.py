"""Commands, benches and verbs that are entry points, each loaded only where it is asked for."""

from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint
from typing import Any


def loaded(entries: Iterable[EntryPoint], words: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the name and the object of the entry point that the first word names, or of all, where it names none.

    Where all are loaded, one that cannot be as a module is missing yields that error as its object.

    Raises
    ------
    ModuleNotFoundError
        Of the one that is named.
    """
    by_name = {entry.name: entry for entry in entries}
    if words and words[0] in by_name:
        yield words[0], by_name[words[0]].load()
        return
    for name in sorted(by_name):
        try:
            yield name, by_name[name].load()
        except ModuleNotFoundError as error:
            yield name, error


def add_missing(subparsers: Any, name: str, error: ModuleNotFoundError) -> None:
    """List what cannot be loaded among commands, with what it misses."""
    subparsers.add_parser(name, help=f"needs {error.name}, which is not installed")

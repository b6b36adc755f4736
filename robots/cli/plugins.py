"""Plug-ins of the command line: commands, benches and verbs from entry points, loaded only when needed."""

from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint
from typing import Any


def loaded(entries: Iterable[EntryPoint], words: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the name and object of the entry point named by the first word, or of all if it names none.

    When all are loaded, an entry point whose module is missing yields the ``ModuleNotFoundError`` as its object.

    Raises
    ------
    ModuleNotFoundError
        The named entry point needs a module that is not installed.
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
    """List a plug-in that cannot be loaded, with the module that it needs."""
    subparsers.add_parser(name, help=f"needs {error.name}, which is not installed")

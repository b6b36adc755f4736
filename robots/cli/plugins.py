"""Plug-ins of the command line: commands, benches and verbs from entry points, loaded only when needed."""

from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint
from typing import Any


def installed(subparsers: Any, entries: Iterable[EntryPoint], words: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the name and object of the entry point named by the first word, or of all if it names none.

    When all are loaded, an entry point whose module is missing is listed in the help, with the module that it needs.

    Parameters
    ----------
    subparsers : subparsers of argparse
        Parsers to which the caller adds one for each object.
    entries : iterable of EntryPoint
    words : sequence of str
        Words of the command line that follow.

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
            found = by_name[name].load()
        except ModuleNotFoundError as error:
            subparsers.add_parser(name, help=f"needs {error.name}, which is not installed")
        else:
            yield name, found

"""Plug-ins of the command line: commands, benches and verbs from entry points, loaded only when needed."""

from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint
from typing import Any

from ppaas.distribution import BrokenPlugin, load_entry, origin
from robots.cli.output import printable

KIND = "subcommand"
"""Noun for an entry point in errors."""


def installed(subparsers: Any, entries: Iterable[EntryPoint], words: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the name and object of the entry point named by the first word, or of all if it names none.

    When all are loaded, an entry point that cannot be loaded is listed in the help with the reason, such as the module
    that it needs.

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
    BrokenPlugin
        The named entry point, of another distribution, cannot be loaded.
    """
    by_name = {entry.name: entry for entry in entries}
    if words and words[0] in by_name:
        yield words[0], _loaded(by_name[words[0]])
        return
    for name in sorted(by_name):
        try:
            found = _loaded(by_name[name])
        except ModuleNotFoundError as error:
            subparsers.add_parser(name, help=f"needs {error.name}, which is not installed")
        except BrokenPlugin as error:
            subparsers.add_parser(name, help=printable(str(error)).replace("%", "%%"))
        else:
            yield name, found


def _loaded(entry: EntryPoint) -> Any:
    found = load_entry(entry, KIND)
    for member in ("HELP", "configure"):
        if not hasattr(found, member):
            raise BrokenPlugin(f"{KIND} {entry.name!r} ({origin(entry)}) has no {member}")
    return found

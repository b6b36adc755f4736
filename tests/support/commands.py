"""Commands of ``ppaas`` and their verbs, as their parsers know them."""

import argparse
from collections.abc import Iterator

from robots.cli.main import parser_of


def leaves(parser: argparse.ArgumentParser | None = None) -> Iterator[argparse.ArgumentParser]:
    """Yield the parsers of a command that have no verbs, or of all commands."""
    found = parser_of([]) if parser is None else parser
    verbs = [action for action in found._actions if isinstance(action, argparse._SubParsersAction)]
    if not verbs:
        yield found
    for action in verbs:
        for verb in dict.fromkeys(action.choices.values()):
            yield from leaves(verb)

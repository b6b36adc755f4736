"""Arguments of a command whose first word is a verb, which may be left out where the command has a default one."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any


class CommandParser(argparse.ArgumentParser):
    """A parser that puts the ``default_verb`` first where the first word is none of its verbs."""

    default_verb: str | None = None
    _verbs: Any = None

    def add_subparsers(self, **options: Any) -> Any:
        """Add the verbs, and remember which there are."""
        self._verbs = super().add_subparsers(**options)
        return self._verbs

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, with the default verb where no verb is; alone, or asked for help, it is the command itself."""
        words: Sequence[str] = sys.argv[1:] if args is None else args
        if self.default_verb and words and words[0] not in (*self._verbs.choices, "-h", "--help"):
            words = [self.default_verb, *words]
        return super().parse_known_args(words, namespace)

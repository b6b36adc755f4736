"""Parser of a command: it may have a default verb, and tells invalid values of arguments as errors of usage."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from ppaas.errors import InvalidParameter


class CommandParser(argparse.ArgumentParser):
    """A parser that puts the ``default_verb`` first where the first word is none of its verbs.

    A function that is the ``type`` of an argument may raise ``InvalidParameter``.
    """

    default_verb: str | None = None

    words: Sequence[str] | None = None
    """What follows the command on the command line; None where the command is not the one that was asked for."""

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

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        try:
            return super()._get_value(action, arg_string)
        except InvalidParameter as error:
            raise argparse.ArgumentError(action, str(error)) from error

"""Argument parser of a command: supports a default verb, and reports invalid values as usage errors."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from ppaas.errors import InvalidParameter


class CommandParser(argparse.ArgumentParser):
    """Parser that inserts the ``default_verb`` if the first word is not one of its verbs.

    The ``type`` function of an argument may raise ``InvalidParameter``. ``words`` of the result are the words of the
    command or verb.
    """

    default_verb: str | None = None

    words: Sequence[str] | None = None
    """Arguments after the name of this command; None if another command was called."""

    _verbs: Any = None

    def add_subparsers(self, **options: Any) -> Any:
        """Add the verbs and remember them."""
        self._verbs = super().add_subparsers(**options)
        return self._verbs

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse; insert the default verb if there is none, except without arguments or with ``--help``."""
        words: Sequence[str] = sys.argv[1:] if args is None else args
        if self.default_verb and words and words[0] not in (*self._verbs.choices, "-h", "--help"):
            words = [self.default_verb, *words]
        found, rest = super().parse_known_args(words, namespace)
        rest = self._filled(found, rest)
        if not hasattr(found, "words"):  # the innermost verb has parsed already
            found.words = list(words)
        return found, rest

    def _filled(self, found: argparse.Namespace, rest: list[str]) -> list[str]:
        """Give words after options to positional arguments that may be left out, which argparse fills before options.

        Returns
        -------
        list of str
            The words that are left.
        """
        left = list(rest)
        for action in self._get_positional_actions():
            is_open = action.nargs == argparse.OPTIONAL and getattr(found, action.dest, None) == action.default
            if is_open and left and not left[0].startswith("-"):
                setattr(found, action.dest, self._get_value(action, left.pop(0)))
        return left

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        try:
            return super()._get_value(action, arg_string)
        except InvalidParameter as error:
            raise argparse.ArgumentError(action, str(error)) from error

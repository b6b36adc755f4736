"""Manual page ``ppaas(1)``, from the parsers of all commands, as the page of the command line."""

import argparse
import os
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from docs.site.reference.commands import meaning, spelled, usage, verbs
from ppaas import __version__
from robots.cli.main import parser_of

NAME = "ppaas.1"
"""Name of the file, as ``man`` looks for it in ``man1/``."""

ENVIRONMENT = {
    "PPAAS_URL": "URL of the cloud, where --url is not given",
    "PPAAS_TOKEN": "token from ppaas login, where --token is not given",
    "SSL_CERT_FILE": "certificates in PEM to trust for https, where --ca-file is not given",
}
"""Environment variables that all commands for a cloud read, with their meanings."""

STATUS = {
    "0": "done",
    "1": "refused or failed; the reason is a line on standard error, with the slug of the error",
    "2": "wrong usage",
    "130": "ended by Ctrl-C",
}
"""Exit statuses of all commands."""


def man_page() -> str:
    """Return the page in the language of man(7)."""
    parser = parser_of([])
    lines = [
        f'.TH PPAAS 1 "{_date()}" "ppaas {__version__}" "User Commands"',
        *_section("NAME", _text("ppaas - Path Planning as a Service")),
        *_section("SYNOPSIS", ".B ppaas", _text("COMMAND [OPTION ...]"), ".br", ".B ppaas", _text("COMMAND --help")),
        *_section("DESCRIPTION", _text(parser.description or "")),
        *_section("COMMANDS", *_commands(parser, "SS")),
        *_section("ENVIRONMENT", *_items(ENVIRONMENT)),
        *_section("EXIT STATUS", *_items(STATUS)),
    ]
    return "\n".join(lines) + "\n"


def _date() -> str:
    """Return the date of the page, which builds that are to give the same bytes state by SOURCE_DATE_EPOCH."""
    return time.strftime("%Y-%m-%d", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))))


def _commands(parser: argparse.ArgumentParser, macro: str) -> Iterator[str]:
    """Yield the lines of the commands of a parser, and of their verbs, with the macro that begins each."""
    for name, command, words in verbs(parser):
        yield f".{macro} {_quoted(' '.join(['ppaas', *usage(command, name)]))}"
        if words:
            yield _text(f"{words[:1].upper()}{words[1:]}.")
        for action in command._actions:
            if action.dest != "help" and not isinstance(action, argparse._SubParsersAction):
                yield from _item(spelled(action), meaning(command, action))
        yield from _commands(command, macro)


def _section(title: str, *lines: str) -> Iterator[str]:
    yield f".SH {_quoted(title)}"
    yield from lines


def _items(rows: dict[str, str]) -> Iterator[str]:
    for term, words in rows.items():
        yield from _item(term, words)


def _item(term: str, words: str) -> Iterator[str]:
    yield ".TP"
    yield f".B {_quoted(term)}"
    yield _text(words or "-")


def _quoted(text: str) -> str:
    """Return a text as one argument of a macro."""
    return '"' + _escaped(text).replace('"', r"\(dq") + '"'


def _text(text: str) -> str:
    """Return a text as a line, which no ``.`` or ``'`` at its beginning makes a request."""
    return re.sub(r"^(?=[.'])", r"\\&", _escaped(text))


def _escaped(text: str) -> str:
    """Return a text in one line whose characters are printed as they are: hyphens that can be copied, ASCII."""
    plain = " ".join(text.replace("\\", r"\e").replace("-", r"\-").split())
    return re.sub(r"[^\x20-\x7e]", lambda found: rf"\[u{ord(found[0]):04X}]", plain)


def main(words: list[str]) -> int:
    """Write the page into a folder; return the exit status."""
    parser = argparse.ArgumentParser("python -m docs.site.man_page", description="Write the manual page of ppaas.")
    parser.add_argument("folder", type=Path, help=f"folder of the file {NAME}")
    folder = parser.parse_args(words).folder
    folder.mkdir(parents=True, exist_ok=True)
    (folder / NAME).write_text(man_page())
    sys.stdout.write(f"man: {folder / NAME}; read it by man -l {folder / NAME}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Page of the command line, from the parsers of all commands."""

import argparse
from collections.abc import Iterator

from docs.site.reference.markdown import cell, code, table
from docs.site.reference.markdown import page as joined
from robots.cli.main import parser_of

INTRODUCTION = """
All commands of `ppaas`, with their verbs and options. `ppaas COMMAND --help` prints the same. `ppaas bench` and its
benches are in checkouts only, and print theirs.
"""


def page() -> str:
    """Return the page."""
    return joined("# Command line", INTRODUCTION, *_sections(parser_of([]), 2))


def _sections(parser: argparse.ArgumentParser, level: int) -> Iterator[str]:
    for name, command, words in verbs(parser):
        yield f"{'#' * level} `{command.prog}`"
        yield cell(f"{words[:1].upper()}{words[1:]}.") if words else ""
        yield code(" ".join(["ppaas", *usage(command, name)]))
        yield _arguments(command)
        yield from _sections(command, level + 1)


def verbs(parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser, str]]:
    """Yield the name, the parser and the help of each command or verb."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {each.dest: each.help or "" for each in action._choices_actions}
            for name, command in action.choices.items():
                yield name, command, _expanded(helps.get(name, ""), command, None)


def usage(command: argparse.ArgumentParser, name: str) -> list[str]:
    """Return the parts of the usage line of a command: its name, its verb and its arguments."""
    words = command.prog.split()[1:] or [name]
    for action in command._actions:
        if isinstance(action, argparse._SubParsersAction):
            words.append(str(action.metavar or "VERB"))
        elif not action.option_strings:
            words.append(_value(action))
        elif action.required:
            words.append(f"{action.option_strings[-1]} {_value(action)}".strip())
    optional = any(each.option_strings and each.dest != "help" and not each.required for each in command._actions)
    return [*words, "[OPTION ...]"] if optional else words


def _arguments(command: argparse.ArgumentParser) -> str:
    rows = [
        (code(spelled(action)), cell(meaning(command, action)) + _choices(action))
        for action in command._actions
        if action.dest != "help" and not isinstance(action, argparse._SubParsersAction)
    ]
    return table(("argument", "meaning (default)"), rows)


def spelled(action: argparse.Action) -> str:
    """Return how an argument is written: its names and its value."""
    if not action.option_strings:
        return _value(action)
    return f"{', '.join(action.option_strings)} {_value(action)}".strip()


def _value(action: argparse.Action) -> str:
    """Return how the value of an argument is written in usages; empty if it takes none."""
    name = action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else "")
    if isinstance(name, tuple):
        return " ".join(name)
    name = name or (action.dest.upper() if action.option_strings else action.dest)
    if isinstance(action.nargs, int):
        return " ".join([name] * action.nargs)
    forms = {None: name, "?": f"[{name}]", "*": f"[{name} ...]", "+": f"{name} [{name} ...]"}
    return forms.get(action.nargs, name)


def _choices(action: argparse.Action) -> str:
    shown = action.metavar and action.choices
    return f" One of {', '.join(map(code, map(str, action.choices or ())))}." if shown else ""


def meaning(command: argparse.ArgumentParser, action: argparse.Action) -> str:
    """Return the help text of an argument of a command."""
    return _expanded(action.help or "", command, action)


def _expanded(words: str, command: argparse.ArgumentParser, action: argparse.Action | None) -> str:
    """Return a help text with the values of its placeholders, such as the default."""
    if not words or words == argparse.SUPPRESS:
        return ""
    values = {**(vars(action) if action else {}), "prog": command.prog}
    return words % values

"""Subcommands from entry points, also of distributions whose code is broken."""

import argparse
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from ppaas.bounded import whole
from ppaas.distribution import BrokenPlugin
from robots.cli.command_parser import CommandParser
from robots.cli.plugins import installed

GROUP = "ppaas.bridges"


class Theirs:
    """Distribution of another maker."""

    name, version = "their-bridge", "1.0"


def theirs(name: str, value: str) -> EntryPoint:
    made = EntryPoint(name, value, GROUP)
    vars(made).update(dist=Theirs())
    return made


@pytest.fixture
def entries(monkeypatch: pytest.MonkeyPatch) -> list[EntryPoint]:
    good, empty = ModuleType("good_bridge"), ModuleType("empty_bridge")
    vars(good).update(HELP="carry", configure=lambda _parser: None)
    for module in (good, empty):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    modules = {"good": "good_bridge", "empty": "empty_bridge", "missing": "no_such_bridge:100%"}
    return [theirs(name, value) for name, value in modules.items()]


def test_the_help_lists_those_that_cannot_be_loaded_with_the_reason(entries: list[EntryPoint]) -> None:
    parser = argparse.ArgumentParser(prog="ppaas")
    verbs = parser.add_subparsers()
    for name, module in installed(verbs, entries, ()):
        verbs.add_parser(name, help=module.HELP)
    words = " ".join(parser.format_help().split())
    assert "good carry" in words
    assert "'empty' (entry point 'empty' = empty_bridge of their-bridge 1.0) has no HELP" in words
    assert "= no_such_bridge:100% of their-bridge 1.0) cannot be loaded" in words


@pytest.mark.parametrize("name", ["empty", "missing"])
def test_one_that_is_named_and_cannot_be_loaded_is_an_error(entries: list[EntryPoint], name: str) -> None:
    verbs = argparse.ArgumentParser().add_subparsers()
    with pytest.raises(BrokenPlugin, match=rf"'{name}' \(entry point .* of their-bridge 1\.0\)"):
        list(installed(verbs, entries, (name,)))
    assert [found for found, _ in installed(verbs, entries, ("good",))] == ["good"]


def parser(default: str | None) -> CommandParser:
    """Return a command with two verbs, below a parser like that of ``ppaas``."""
    root = CommandParser("root")
    command = root.add_subparsers(required=True).add_parser("do", description="what it does")
    verbs = command.add_subparsers(dest="verb", required=True)
    for name in ("make", "list"):
        verb = verbs.add_parser(name)
        verb.add_argument("thing")
        verb.add_argument("--at", type=float)
    command.default_verb = default
    return root


@pytest.mark.parametrize(
    ("words", "verb", "thing"),
    [
        (["box"], "make", "box"),
        (["make", "box"], "make", "box"),
        (["list", "box"], "list", "box"),
        (["--at", "-1", "box"], "make", "box"),
        (["make", "list"], "make", "list"),
    ],
)
def test_the_default_verb_is_used_if_no_verb_is_given(words, verb, thing):
    parsed = parser("make").parse_args(["do", *words])
    assert (parsed.verb, parsed.thing) == (verb, thing)


def test_an_unknown_verb_is_refused_without_a_default_verb(capsys):
    with pytest.raises(SystemExit):
        parser(None).parse_args(["do", "box"])
    assert "invalid choice: 'box'" in capsys.readouterr().err


def test_help_and_a_missing_verb_show_the_command_itself(capsys):
    for words, status in ((["--help"], 0), (["-h"], 0), ([], 2)):
        with pytest.raises(SystemExit) as end:
            parser("make").parse_args(["do", *words])
        assert end.value.code == status
    output = capsys.readouterr()
    assert output.out.count("what it does") == 2
    assert "required: verb" in output.err


@pytest.mark.parametrize("words", [["--count", "0", "box"], ["--of", "0", "box"]])
def test_a_parameter_refused_by_its_type_is_a_usage_error(words, capsys):
    root = CommandParser("root")
    command = root.add_subparsers(required=True).add_parser("do")
    command.add_argument("thing")
    command.add_argument("--count", type=whole())
    command.add_mutually_exclusive_group().add_argument("--of", type=whole())
    with pytest.raises(SystemExit) as end:
        root.parse_args(["do", *words])
    assert end.value.code == 2
    assert capsys.readouterr().err.endswith(
        f"root do: error: argument {words[0]}: expected a whole number of at least 1, not '0'\n"
    )

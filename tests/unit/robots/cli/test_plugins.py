"""Subcommands from entry points, also of distributions whose code is broken."""

import argparse
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from ppaas.distribution import BrokenPlugin
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

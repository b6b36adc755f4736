"""Globs of topics and robots, and addresses of robots."""

import re

import pytest

from engine.rights.globs import GLOB, ROBOT_GLOB, bare, is_address, is_in_scope, matches, split_address
from storage.sharing_records import TokenScope


@pytest.mark.parametrize(
    ("glob", "matched"),
    [
        ("*", {"cmd_vel", "move_base/goal", "move_base/status", "map"}),
        ("cmd_vel", {"cmd_vel"}),
        ("/cmd_vel", {"cmd_vel"}),
        ("move_base/*", {"move_base/goal", "move_base/status"}),
        ("*/status", {"move_base/status"}),
        ("ma?", {"map"}),
        ("[!m]*", {"cmd_vel"}),
    ],
)
def test_globs_match_as_in_the_shell(glob: str, matched: set[str]) -> None:
    assert re.fullmatch(GLOB, glob)
    names = ("cmd_vel", "move_base/goal", "move_base/status", "map")
    assert {name for name in names if matches(name, [bare(glob)])} == matched


@pytest.mark.parametrize("text", ["", "/", "a b", "a\n", "ä", "x" * 130, "{a,b}", "cmd_vel;"])
def test_other_texts_are_no_globs(text: str) -> None:
    assert not re.fullmatch(GLOB, text)


def test_robots_of_others_are_in_scope_only_with_their_owner() -> None:
    scope = TokenScope(("tb*", "carl:kobuki", "d*:*"), "look")
    robots = [(o, r) for o in ("ann", "carl", "dora") for r in ("tb1", "kobuki") if is_in_scope(scope, "ann", o, r)]
    assert robots == [("ann", "tb1"), ("carl", "kobuki"), ("dora", "tb1"), ("dora", "kobuki")]
    for glob in scope.robots:
        assert re.fullmatch(ROBOT_GLOB, glob)


def test_an_address_names_the_owner_unless_it_is_the_caller() -> None:
    assert split_address("tb1", "ann") == ("ann", "tb1")
    assert split_address("bob:tb1", "ann") == ("bob", "tb1")
    assert [text for text in ("tb1", "bob:tb1", ":tb1", "bob:", "a:b:c", "bob/tb1") if is_address(text)] == [
        "tb1", "bob:tb1",
    ]  # fmt: skip

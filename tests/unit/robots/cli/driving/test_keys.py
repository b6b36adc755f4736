"""Keys of a terminal: what is sent for each, and how long one that is not released counts."""

import pytest

from robots.cli.driving.keys import FIRST_REPEAT, GAP, MOVES, SLOWEST, TAP, HeldKey, keys_in


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("iI,", ["i", "i", ","]),
        ("\x1b[A\x1b[D\x1bOC", ["up", "left", "right"]),
        ("\x1b", ["escape"]),
        ("\x1b[1;5Ai", ["?", "i"]),
        ("\x1b[3~", ["?"]),
        ("\x1b[", ["escape", "["]),
        ("\x1b[1", ["?"]),
        ("\x1bi", ["escape", "i"]),
        ("é \x04", ["é", " ", "\x04"]),
    ],
)
def test_what_a_terminal_sends_is_read_as_keys(text: str, keys: list[str]) -> None:
    assert list(keys_in(text)) == keys


def test_a_press_drives_for_a_moment_and_repeats_keep_it_driving_until_they_end() -> None:
    held = HeldKey(0.5)
    held.press("i", 10.0)
    assert held.motion(10.0) == (0.5, 0.0)
    assert held.motion(10.0 + TAP) is None, "it was a tap"
    held.press("i", 10.5)
    for number in range(1, 20):
        now = 10.5 + number * 0.1
        assert held.motion(now) == (0.5, 0.0)
        held.press("i", now)
    assert held.motion(now + GAP - 0.01) == (0.5, 0.0)
    assert held.motion(now + GAP) is None


def test_a_key_that_is_pressed_again_later_is_a_tap() -> None:
    held = HeldKey(1.0)
    held.press("j", 0.0)
    held.press("j", FIRST_REPEAT + 0.1)
    assert held.motion(FIRST_REPEAT + 0.1 + GAP + 0.01) == (0.0, 1.0)


@pytest.mark.parametrize("key", ["k", " ", "?", "x", "\n"])
def test_any_other_key_stops_at_once(key: str) -> None:
    held = HeldKey(1.0)
    held.press("w", 0.0)
    held.press(key, 0.05)
    assert held.motion(0.05) is None


def test_the_last_key_counts_and_opposite_keys_oppose_each_other() -> None:
    held = HeldKey(1.0)
    held.press("u", 0.0)
    held.press("d", 0.1)
    assert held.motion(0.15) == (0.0, -1.0)
    for one, other in ("i,", "jl", "um", "o.", "ws", "ad", ("up", "down"), ("left", "right")):
        assert MOVES[one] == tuple(-part for part in MOVES[other])


def test_speeds_change_in_steps_within_limits_and_do_not_drive() -> None:
    held = HeldKey(0.5)
    held.press("q", 0.0)
    assert held.speed == pytest.approx(0.55)
    assert held.motion(0.0) is None
    for _ in range(50):
        held.press("q", 0.0)
    assert held.speed == 1.0
    for _ in range(50):
        held.press("z", 0.0)
    assert held.speed == SLOWEST

"""Teleoperation: one driver at a time, and no velocity after a fault, a release, or the end of a turn."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.operators.teleoperation import TeleopCommand
from ppaas.navigation.teleoperation import Teleoperation, TeleopParameters

LIMITS = TeleopParameters()
FASTEST = Velocity(0.5, 1.0)
STAND = Velocity()


class Hand:
    """A driver's program on a link without delay."""

    def __init__(self, machine: Teleoperation, name: str = "ada") -> None:
        self.machine = machine
        self.name = name
        self.number = 0

    def send(self, now: float, linear: float = 0.0, *, enable: bool = True, **fields: Any) -> None:
        self.number += 1
        seen = self.machine.next_state(now)
        given = {"echo": seen, "view": seen, "driver": self.name} | fields
        self.machine.take(TeleopCommand(f"id-{self.name}", self.number, linear, 0.0, enable, **given), now)

    def begin(self, now: float = 0.0, request: str = "drive") -> None:
        self.send(now, enable=False, request=request)


@pytest.fixture
def machine() -> Teleoperation:
    return Teleoperation(LIMITS, FASTEST)


@pytest.fixture
def ada(machine: Teleoperation) -> Hand:
    hand = Hand(machine)
    hand.begin()
    return hand


def driver_of(machine: Teleoperation) -> str:
    return "" if machine.driver is None else machine.driver.name


# -- the driver --------------------------------------------------------------------------------------------------------


def test_nobody_drives_without_a_request(machine: Teleoperation) -> None:
    Hand(machine).send(0.0, 0.3)
    assert driver_of(machine) == ""
    assert machine.velocity(0.0) == STAND


def test_a_driver_drives_while_the_control_is_held(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3)
    assert machine.velocity(0.1) == Velocity(0.3, 0.0)
    ada.send(0.2, 0.3, enable=False)
    assert machine.velocity(0.2) == STAND


def test_a_second_client_waits_or_takes_over(machine: Teleoperation, ada: Hand) -> None:
    bob = Hand(machine, "bob")
    ada.send(0.1, 0.3)
    bob.begin(0.15)
    assert driver_of(machine) == "ada"
    bob.begin(0.2, "take over")
    assert driver_of(machine) == "bob"
    assert machine.velocity(0.2) == STAND
    ada.send(0.25, 0.3)
    assert machine.velocity(0.25) == STAND
    ada.send(0.26, enable=False, request="leave")
    assert driver_of(machine) == "bob"
    bob.send(0.3, 0.2)
    assert machine.velocity(0.3) == Velocity(0.2, 0.0)


def test_a_request_that_is_repeated_changes_nothing(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3, request="take over")
    assert machine.velocity(0.1) == Velocity(0.3, 0.0)


def test_a_driver_leaves(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3)
    ada.send(0.2, 0.3, request="leave")
    assert driver_of(machine) == ""
    assert machine.velocity(0.2) == STAND
    ada.send(0.3, 0.3)
    assert driver_of(machine) == "", "a command alone does not begin a turn"


def test_the_turn_of_a_silent_driver_lapses(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3)
    machine.expire(0.09 + LIMITS.lease_timeout)
    assert driver_of(machine) == "ada"
    machine.expire(0.11 + LIMITS.lease_timeout)
    assert driver_of(machine) == ""
    assert machine.velocity(0.2) == STAND


def test_a_control_that_was_held_before_does_not_drive(machine: Teleoperation) -> None:
    bob = Hand(machine, "bob")
    bob.send(0.0, 0.3, request="drive")
    bob.send(0.1, 0.3)
    assert machine.velocity(0.1) == STAND
    assert machine.driver is not None and "held before" in machine.driver.lock


# -- ages --------------------------------------------------------------------------------------------------------------


def test_a_late_command_stops_until_the_control_is_let_go(machine: Teleoperation, ada: Hand) -> None:
    old = machine.next_state(1.0)
    ada.send(1.1, 0.3)
    ada.send(1.0 + LIMITS.command_timeout + 0.01, 0.3, echo=old)
    assert machine.velocity(1.4) == STAND
    assert machine.driver is not None and "late" in machine.driver.lock
    ada.send(1.5, 0.3)
    assert machine.velocity(1.5) == STAND, "it is still held"
    ada.send(1.6, enable=False)
    ada.send(1.7, 0.3)
    assert machine.velocity(1.7) == Velocity(0.3, 0.0)


def test_time_for_which_a_state_lay_at_the_driver_is_no_delay(machine: Teleoperation, ada: Hand) -> None:
    seen = machine.next_state(1.0)
    ada.send(1.5, 0.3, echo=seen, held=0.45)
    assert machine.velocity(1.5) == Velocity(0.3, 0.0)


def test_silence_stops_until_the_control_is_let_go(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3)
    assert machine.velocity(0.09 + LIMITS.command_timeout) == Velocity(0.3, 0.0)
    assert machine.velocity(0.11 + LIMITS.command_timeout) == STAND
    ada.send(0.5, 0.3)
    assert machine.velocity(0.5) == STAND


def test_an_old_view_stops(machine: Teleoperation, ada: Hand) -> None:
    seen = machine.next_state(1.0)
    ada.send(1.0 + LIMITS.view_timeout, 0.3, view=seen)
    assert machine.velocity(2.0) == Velocity(0.3, 0.0)
    ada.send(1.1 + LIMITS.view_timeout, 0.3, view=seen)
    assert machine.velocity(2.1) == STAND
    assert machine.driver is not None and machine.driver.lock == "the view is 1.1 s old"


def test_a_state_that_was_never_published_is_no_echo(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3, echo=10_000)
    assert machine.velocity(0.1) == STAND


def test_a_command_that_comes_twice_or_late_is_ignored(machine: Teleoperation, ada: Hand) -> None:
    ada.send(0.1, 0.3)
    ada.send(0.2, enable=False)
    ada.number = 1
    ada.send(0.25, 0.3)
    assert machine.velocity(0.25) == STAND


# -- limits and bad input ----------------------------------------------------------------------------------------------


def test_a_velocity_beyond_the_limits_is_slowed_on_its_arc(machine: Teleoperation, ada: Hand) -> None:
    ada.number += 1
    seen = machine.next_state(0.1)
    machine.take(TeleopCommand("id-ada", ada.number, -1.0, 4.0, True, echo=seen, view=seen), 0.1)
    assert machine.velocity(0.1) == Velocity(-0.25, 1.0)


@pytest.mark.parametrize(
    "fields",
    [
        {"linear": math.nan},
        {"angular": math.inf},
        {"held": -0.1},
        {"held": math.nan},
        {"id": ""},
        {"id": "x" * 65},
        {"request": "fly"},
    ],
)
def test_a_bad_command_is_refused(machine: Teleoperation, fields: dict[str, Any]) -> None:
    command = {"id": "a", "number": 1, "request": "drive"} | fields
    with pytest.raises(InvalidInput):
        machine.take(TeleopCommand(**command), 0.0)
    assert machine.driver is None


@pytest.mark.parametrize("name", TeleopParameters.__struct_fields__)
def test_parameters_are_above_0(name: str) -> None:
    with pytest.raises(InvalidParameter, match=name):
        TeleopParameters(**{name: 0.0})


# -- whatever comes ----------------------------------------------------------------------------------------------------

STEP = st.tuples(
    st.sampled_from(["ada", "bob"]),
    st.sampled_from(["", "", "", "", "drive", "take over", "leave"]),
    st.booleans(),
    st.floats(0.0, 0.5),
    st.floats(0.0, 1.5),
    st.floats(0.0, 2.5),
)
"""Who sends, what it requests, whether the control is held, ages of echo and view, time until the next step [s]."""


@given(st.lists(STEP, max_size=40))
def test_no_velocity_without_a_recent_command_of_the_driver_who_holds_the_control(steps: list[tuple[Any, ...]]) -> None:
    machine = Teleoperation(LIMITS, FASTEST)
    states: dict[int, float] = {}
    now, last = 10.0, ("", -math.inf)

    def published_by(at: float) -> int:
        return max((each for each, came in states.items() if came <= at), default=0)

    for number, (name, request, enable, late, old, pause) in enumerate(steps, 1):
        states[machine.next_state(now)] = now
        echo, view = published_by(now - late), published_by(now - old)
        ages = now - states.get(echo, -math.inf), now - states.get(view, -math.inf)
        command = TeleopCommand(name, number, 0.3, 0.0, enable, echo=echo, view=view, request=request, driver=name)
        machine.take(command, now)
        if driver_of(machine) in ("", name):
            counts = enable and ages[0] <= LIMITS.command_timeout and ages[1] <= LIMITS.view_timeout
            last = (name, now) if counts else ("", -math.inf)
        for wait in (0.0, 0.5 * pause, pause):
            machine.expire(now + wait)
            if machine.velocity(now + wait) != STAND:
                assert last[0] == driver_of(machine) != ""
                assert now + wait - last[1] <= LIMITS.command_timeout
        now += pause

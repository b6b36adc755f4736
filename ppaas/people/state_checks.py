"""Checks of messages between robots and their coordinator."""

import math

from ppaas.errors import InvalidInput
from ppaas.messages.people_coordination import PeopleState, SensorView

LARGEST = 1e5
"""Largest number of a view [m, rad]."""


def check_state(state: PeopleState) -> None:
    """Check that positions and velocities are finite.

    Raises
    ------
    InvalidInput
        A number is not; the text names the person or the robot.
    """
    for person in state.people:
        numbers = (person.position.x, person.position.y, person.velocity.x, person.velocity.y)
        if not all(map(math.isfinite, numbers)):
            raise InvalidInput(f"the position and velocity of person {person.id} must be finite")
    for robot in state.robots:
        if not all(map(math.isfinite, (robot.position.x, robot.position.y))):
            raise InvalidInput(f"the position of robot {robot.robot!r} must be finite")


def check_view(view: SensorView, what: str) -> None:
    """Check that the numbers of a view are plausible; ``what`` names it in errors.

    Raises
    ------
    InvalidInput
        One is not finite, or out of range.
    """
    numbers = (view.x, view.y, view.yaw, view.field_of_view, view.range_min, view.range_max)
    # NaN compares as false.
    if not all(abs(number) <= LARGEST for number in numbers) or min(view.field_of_view, view.range_min) < 0.0:
        raise InvalidInput(
            f"{what}: its numbers must be finite, up to {LARGEST:g}, and angles and ranges must not be negative"
        )

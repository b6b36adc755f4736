"""Checks of the coordinator's messages."""

import math

from ppaas.errors import InvalidInput
from ppaas.messages.people_coordination import PeopleState


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

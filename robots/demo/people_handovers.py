"""Handovers of people between robots, and those that are reverted soon."""

FLAP = 5.0
"""Time within which a handover that is reverted is a flap [s]."""


class Handovers:
    """Counts handovers: a person whom one robot followed is followed by another.

    Attributes
    ----------
    number : int
        Number of handovers.
    flaps : int
        Number of handovers that reverted another within `FLAP`.
    """

    def __init__(self) -> None:
        self.number = self.flaps = 0
        self._robot: dict[int, str] = {}
        self._left: dict[tuple[int, str], float] = {}

    def take(self, time: float, person: int, robot: str) -> bool:
        """Note that a robot follows a person at a time [s]; return whether it took over from another robot."""
        before = self._robot.get(person, robot)
        self._robot[person] = robot
        if before == robot:
            return False
        self.number += 1
        self.flaps += time - self._left.get((person, robot), float("-inf")) <= FLAP
        self._left[person, before] = time
        return True

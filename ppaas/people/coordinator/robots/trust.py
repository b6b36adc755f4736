"""Trust in a robot: its reports compared with the map and with what all other robots see."""

import math
from collections.abc import Collection

MEMORY = 10.0
"""Time constant with which evidence is forgotten [s]."""
ENOUGH = 4.0
"""Evidence from which a robot is judged [s]: a person whom others confirm or deny for one second counts one."""
ENOUGH_WALLED = 8.0
"""Evidence from which a robot is judged by the map, which may have obstacles that a camera looks over [s]."""
DENIED = 0.7
"""Share of denied people from which a robot is not trusted."""
BELIEVED = 0.4
"""Share of denied people below which it is trusted again."""
WITNESSES = 2
"""Number of robots that must deny its people, unless one of them is reliable."""
RELIABLE = 2.0
"""Evidence from which a robot is reliable: others confirm its people [s]."""
WALLS = "sees people inside or behind walls: its position on the map may be wrong; localize it again"
ALONE = "sees people where no other robot sees any; check its detector and its position on the map"


class TrustRecord:
    """Evidence for and against the reports of a robot.

    Attributes
    ----------
    reason : str
        Why its reports are not used; empty while it is trusted.
    """

    def __init__(self) -> None:
        self.reason = ""
        self.confirmed = self.denied = self.open = self.walled = 0.0
        self.witnesses: dict[str, float] = {}

    @property
    def trusted(self) -> bool:
        """Whether its reports are used."""
        return not self.reason

    def forget(self, seconds: float) -> None:
        """Fade the evidence over a time [s]."""
        fading = math.exp(-seconds / MEMORY)
        self.confirmed *= fading
        self.denied *= fading
        self.open *= fading
        self.walled *= fading
        self.witnesses = {robot: fading * weight for robot, weight in self.witnesses.items() if weight > 0.05}

    def see(self, seconds: float, *, walled: int, clear: int) -> None:
        """Add a number of people who are in or behind walls, and of others, for a time [s]."""
        self.walled += seconds * walled
        self.open += seconds * clear

    def compare(self, seconds: float, *, confirmed: int, denied: int, witnesses: list[str]) -> None:
        """Add a number of its people whom others confirm or deny for a time [s], and the robots that deny some."""
        self.confirmed += seconds * confirmed
        self.denied += seconds * denied
        for robot in witnesses:
            self.witnesses[robot] = self.witnesses.get(robot, 0.0) + seconds

    @property
    def reliable(self) -> bool:
        """Whether other robots confirm its people."""
        return self.trusted and self.confirmed >= RELIABLE and self.confirmed > self.denied

    def judge(self, reliable: Collection[str]) -> None:
        """Decide whether the robot is trusted, knowing which other robots are reliable."""
        share = DENIED if self.trusted else BELIEVED
        if self.walled + self.open >= ENOUGH_WALLED and self.walled > share * (self.walled + self.open):
            self.reason = WALLS
        elif self._denied(share, reliable):
            self.reason = ALONE
        else:
            self.reason = ""

    def _denied(self, share: float, reliable: Collection[str]) -> bool:
        total = self.confirmed + self.denied
        deny = [robot for robot, weight in self.witnesses.items() if weight > 0.25 * ENOUGH]
        accusers = len(deny) + (WITNESSES - 1 if any(robot in reliable for robot in deny) else 0)
        # A robot that was denied stays so while it reports nobody, until the evidence has faded.
        return (
            total >= 0.5 * ENOUGH * (2.0 if self.trusted else 1.0)
            and self.denied > share * total
            and (accusers >= WITNESSES or (not self.trusted and accusers > 0))
        )

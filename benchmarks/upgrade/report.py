"""Report of an upgrade, for people and for programs."""

from typing import Any

import msgspec

BAR = 2.0
"""Longest time for which a robot may be served by nobody [s]."""


class UpgradeStep(msgspec.Struct, frozen=True):
    """Step of an upgrade.

    Parameters
    ----------
    name : str
    seconds : float
        Duration [s].
    gap : float
        Longest time that a robot with a goal got no velocity command during the step or just after it [s]; 0 for less
        than half a second, in which a base goes on.
    silence : float
        Longest time that such a robot got no feedback of a control cycle either: no clone served it [s].
    """

    name: str
    seconds: float
    gap: float
    silence: float


class UpgradeReport(msgspec.Struct, frozen=True):
    """Upgrade of a cloud, and its effects on robots.

    Parameters
    ----------
    before, after : str
        Releases.
    robots : int
    killed : bool
        Whether processes were killed instead of ended.
    steps : list of UpgradeStep
        The time before the upgrade, and its steps.
    goals, lost : int
        Number of goals that were sent, and of those that were lost.
    commands : int
        Number of velocity commands.
    releases : dict of str to str
        Releases of the machines after the upgrade.
    wrong : list of str
        Errors.
    """

    before: str
    after: str
    robots: int
    killed: bool
    steps: list[UpgradeStep]
    goals: int
    lost: int
    commands: int
    releases: dict[str, str]
    wrong: list[str]

    @property
    def passed(self) -> bool:
        """Whether the upgrade passed: no goal lost, no fault found, and no robot without service for long."""
        return not (self.lost or self.wrong) and max(step.silence for step in self.steps) <= BAR

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each step."""
        return [
            {
                "step": step.name,
                "took s": f"{step.seconds:.1f}",
                "longest gap s": f"{step.gap:.2f}",
                "served by nobody s": f"{step.silence:.2f}",
            }
            for step in self.steps
        ]

    def sentences(self) -> list[str]:
        """Return the summary for people, one line each."""
        return [
            f"{self.robots} robots, from {self.before} to {self.after}"
            + (", each process killed" if self.killed else ""),
            f"{self.goals} goals, {self.lost} lost; {self.commands} commands",
            *(f"WRONG: {one}" for one in self.wrong),
            "nothing was lost" if self.passed else f"not within the bar: 0 goals lost, {BAR:g} s served by nobody",
        ]

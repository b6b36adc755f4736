"""What a run of faults came to, for people and for programs."""

from collections import Counter
from collections.abc import Mapping, Sequence

import msgspec

from benchmarks.chaos.faults import InjectedFault
from benchmarks.chaos.silences import Gap

BEFORE = 1.0
"""Seconds before a gap within which a fault may have caused it: a robot drives on by what is still on its way."""

NO_FAULT, SEVERAL = "none", "several"

LONGEST = 10
"""So many of the longest silences are told one by one."""


class Silence(msgspec.Struct, frozen=True):
    """A time in which nobody served a robot, from and to [seconds since the run began], and what can have caused it."""

    robot: str
    begin: float
    end: float
    causes: list[str]


class ChaosReport(msgspec.Struct, frozen=True):
    """What was done, and what came of it.

    Parameters
    ----------
    seed, robots, machines : int
        Of the run.
    seconds : float
        How long faults were done.
    faults : dict of str to int
        How many of each kind.
    longest_gap_s : dict of str to float
        Longest time that a robot with a goal was commanded nothing, by the fault that can have caused it; under
        ``several`` where another came before it was over, under ``none`` where there was no fault.
    longest_silence_s : dict of str to float
        Longest time that such a robot heard of no control cycle, in the same way: nobody served it. In the rest of a
        gap its clone planned anew or recovered, for robots stand in each other's way.
    goals : dict of str to int
        How many were sent; of how many a ``result`` came, the ``status`` was told, or it was told that they are
        ``lost``.
    statuses : dict of str to int
        How goals ended.
    paths : dict of str to int
        Requests by REST that were answered with a path, or refused, and why.
    commands : int
        That robots were given.
    sessions : int
        That robots began, one each if none was lost.
    cloud_starts : int
        How often the cloud was started again.
    log : list of InjectedFault
        What was done, when: seconds since the run began.
    silences : list of Silence
        The longest of them.
    wrong : list of str
        What should not have been, and when.
    """

    seed: int
    robots: int
    machines: int
    seconds: float
    faults: dict[str, int]
    longest_gap_s: dict[str, float]
    longest_silence_s: dict[str, float]
    goals: dict[str, int]
    statuses: dict[str, int]
    paths: dict[str, int]
    commands: int
    sessions: int
    cloud_starts: int
    log: list[InjectedFault]
    silences: list[Silence]
    wrong: list[str]

    @property
    def passed(self) -> bool:
        """Tell whether all was as it should be."""
        return not self.wrong

    def rows(self) -> list[dict[str, object]]:
        """Return a row for each kind of fault."""
        names = sorted({*self.faults, *self.longest_gap_s, *self.longest_silence_s})
        return [
            {
                "fault": name,
                "times": self.faults.get(name, 0),
                "longest gap s": self.longest_gap_s.get(name),
                "served by nobody s": self.longest_silence_s.get(name),
            }
            for name in names
        ]

    def sentences(self) -> list[str]:
        """Return the rest, for people."""
        goals = self.goals
        return [
            f"{self.robots} robots on {self.machines} machines, {sum(self.faults.values())} faults in "
            f"{self.seconds:.0f} s (seed {self.seed}); {self.commands} commands",
            f"goals: {goals['sent']} sent; the end of {goals['result']} told by their result, of {goals['status']} by "
            f"the list of statuses; {goals['lost']} lost with the cloud, which was told",
            f"paths by REST: {_counted(self.paths)}; the cloud was started {self.cloud_starts} times again",
            *(f"WRONG: {one}" for one in self.wrong),
            "nothing was lost, said twice or left behind" if self.passed else f"{len(self.wrong)} things are wrong",
        ]


def longest_by_fault(faults: Sequence[InjectedFault], gaps: Sequence[Gap]) -> dict[str, float]:
    """Return the longest gap for each kind of fault, for several at a time, and for none."""
    longest: dict[str, float] = {}
    for gap in gaps:
        causes = causes_of(faults, gap)
        cause = (causes or [NO_FAULT])[0] if len(causes) < 2 else SEVERAL
        longest[cause] = round(max(gap.seconds, longest.get(cause, 0.0)), 2)
    return longest


def log_of(faults: Sequence[InjectedFault], began: float) -> list[InjectedFault]:
    """Return faults by seconds since the run began."""
    return [
        msgspec.structs.replace(
            fault, at=round(fault.at - began, 1), until=round(fault.until - began, 1) if fault.until else 0.0
        )
        for fault in faults
    ]


def causes_of(faults: Sequence[InjectedFault], gap: Gap) -> list[str]:
    """Return the faults that were done shortly before a gap or in it, or had stopped what stood still then."""
    return [fault.name for fault in faults if fault.at <= gap.end and max(fault.at, fault.until) >= gap.begin - BEFORE]


def longest_silences(faults: Sequence[InjectedFault], gaps: Mapping[str, Sequence[Gap]], began: float) -> list[Silence]:
    """Return the longest silences of all robots, which are given by their names; ``began`` is when the run did."""
    silences = [
        Silence(robot, round(gap.begin - began, 1), round(gap.end - began, 1), causes_of(faults, gap))
        for robot, own in gaps.items()
        for gap in own
    ]
    return sorted(silences, key=lambda silence: silence.begin - silence.end)[:LONGEST]


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(counts).items())) or "none"

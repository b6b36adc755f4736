"""Report of a chaos run, for people and for programs."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from benchmarks.chaos.faults import InjectedFault
from benchmarks.chaos.message_checks import Gap

BEFORE = 1.0
"""Longest time from a fault to a gap that it caused [s]: messages in flight still reach the robot."""

BEFORE_STRAYING = 10.0
"""Longest time after a fault within which it may have led a robot astray [s]."""

NO_FAULT, SEVERAL = "none", "several"

LONGEST = 10
"""Number of longest silences that the report lists."""


class ServiceGap(msgspec.Struct, frozen=True):
    """Time in which no clone served a robot [s since the run began], and the faults that can have caused it."""

    robot: str
    begin: float
    end: float
    causes: list[str]


class Stray(msgspec.Struct, frozen=True):
    """Time in which a robot was far from its believed pose [s since the run began], and the faults just before it."""

    robot: str
    begin: float
    end: float
    before: list[str]


class ChaosReport(msgspec.Struct, frozen=True):
    """Injected faults and their effects.

    Parameters
    ----------
    seed, robots, operators, machines : int
        Settings of the run.
    standby : bool
        Whether a second cloud process stood by.
    seconds : float
        Duration of the injection [s].
    faults : dict of str to int
        Number of faults of each kind.
    longest_gap_s : dict of str to float
        Longest time that a robot with a goal received no command, by the fault that can have caused it; under
        ``several`` if there were more than one, under ``none`` without a fault.
    longest_silence_s : dict of str to float
        Longest time that such a robot received no feedback of a control cycle, by fault as above: no clone served
        it. In the rest of a gap its clone replanned or recovered, since robots block each other.
    goals : dict of str to int
        Number of goals ``sent``, and of those whose end was known by their ``result``, by the list of statuses
        (``status``), or that were reported ``lost``.
    statuses : dict of str to int
        Number of goals by their final status.
    not_reached : dict of str to int
        Number of goals that were not reached by robot, status and reason; the most frequent ones.
    paths : dict of str to int
        Path requests by REST, by their answer: a path, or the code of an error.
    commands : int
        Number of commands that robots received.
    sessions : int
        Number of sessions; one for each robot if none was lost.
    cloud_starts : int
        Number of restarts of cloud processes.
    take_overs : int
        Number of times that another cloud process than before led.
    log : list of InjectedFault
        All faults, in seconds since the run began.
    silences : list of ServiceGap
        The longest silences.
    wrong : list of str
        Descriptions of all errors, with their times.
    fleet, fleet_contacts : int
        Number of further robots, which take part in traffic, and of their contacts with each other.
    throttled, throttled_messages : int
        Number of clients of each robot that subscribed with throttle rates, and of the messages that they received.
    strays : list of Stray
        All times in which a robot was astray.
    """

    seed: int
    robots: int
    operators: int
    machines: int
    standby: bool
    seconds: float
    faults: dict[str, int]
    longest_gap_s: dict[str, float]
    longest_silence_s: dict[str, float]
    goals: dict[str, int]
    statuses: dict[str, int]
    not_reached: dict[str, int]
    paths: dict[str, int]
    commands: int
    sessions: int
    cloud_starts: int
    take_overs: int
    log: list[InjectedFault]
    silences: list[ServiceGap]
    wrong: list[str]
    fleet: int = 0
    fleet_contacts: int = 0
    throttled: int = 0
    throttled_messages: int = 0
    strays: list[Stray] = []

    @property
    def passed(self) -> bool:
        """Whether no error was found."""
        return not self.wrong

    def rows(self) -> list[dict[str, Any]]:
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
        """Return the summary for people, one line each."""
        goals = self.goals
        return [
            f"{self.robots} robots, {self.operators} with an operator, on {self.machines} machines; "
            f"{sum(self.faults.values())} faults in "
            f"{self.seconds:.0f} s (seed {self.seed}); {self.commands} commands",
            f"goals: {goals['sent']} sent; {goals['result']} ended with a result, {goals['status']} by the list of "
            f"statuses; {goals['lost']} reported lost",
            f"paths by REST: {_counted(self.paths)}; the cloud was restarted {self.cloud_starts} times"
            + (f", another process took over {self.take_overs} times" if self.standby else ""),
            *([f"{self.fleet} more robots in traffic: {self.fleet_contacts} contacts"] if self.fleet else ()),
            *(
                [f"{self.throttled} throttled clients of each robot: {self.throttled_messages} messages"]
                if self.throttled
                else ()
            ),
            *(
                f"{one.robot} was astray from {one.begin} to {one.end} s, after {', '.join(one.before) or 'no fault'}"
                for one in self.strays
            ),
            *(f"WRONG: {one}" for one in self.wrong),
            "nothing was lost, repeated or left behind" if self.passed else f"errors: {len(self.wrong)}",
        ]


def longest_by_fault(faults: Sequence[InjectedFault], gaps: Sequence[Gap]) -> dict[str, float]:
    """Return the longest gap [s] by the kind of fault that caused it, or ``several``, or ``none``."""
    longest: dict[str, float] = {}
    for gap in gaps:
        causes = causes_of(faults, gap)
        cause = (causes or [NO_FAULT])[0] if len(causes) < 2 else SEVERAL
        longest[cause] = round(max(gap.seconds, longest.get(cause, 0.0)), 2)
    return longest


def log_of(faults: Sequence[InjectedFault], began: float) -> list[InjectedFault]:
    """Return the faults with times in seconds since the run began."""
    return [
        msgspec.structs.replace(
            fault, at=round(fault.at - began, 1), until=round(fault.until - began, 1) if fault.until else 0.0
        )
        for fault in faults
    ]


def causes_of(faults: Sequence[InjectedFault], gap: Gap) -> list[str]:
    """Return the faults that occurred during a gap or shortly before it, or whose process was stopped then."""
    return [fault.name for fault in faults if fault.at <= gap.end and max(fault.at, fault.until) >= gap.begin - BEFORE]


def longest_silences(
    faults: Sequence[InjectedFault], gaps: Mapping[str, Sequence[Gap]], began: float
) -> list[ServiceGap]:
    """Return the longest silences of all robots.

    Parameters
    ----------
    faults : sequence of InjectedFault
    gaps : mapping of str to sequence of Gap
        Gaps by name of robot.
    began : float
        Begin of the run [monotonic s].
    """
    silences = [
        ServiceGap(robot, round(gap.begin - began, 1), round(gap.end - began, 1), causes_of(faults, gap))
        for robot, own in gaps.items()
        for gap in own
    ]
    return sorted(silences, key=lambda silence: silence.begin - silence.end)[:LONGEST]


def strays_of(faults: Sequence[InjectedFault], gaps: Mapping[str, Sequence[Gap]], began: float) -> list[Stray]:
    """Return all times in which robots were astray, by name of robot, in their order; ``began`` as above."""
    strays = [
        Stray(
            robot,
            round(gap.begin - began, 1),
            round(gap.end - began, 1),
            [fault.name for fault in faults if 0.0 <= gap.begin - max(fault.at, fault.until) <= BEFORE_STRAYING],
        )
        for robot, own in gaps.items()
        for gap in own
    ]
    return sorted(strays, key=lambda stray: stray.begin)


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(counts).items())) or "none"

"""Joint maps: the choice of the maps that are joined next, and the results of attempts. It does no I/O.

Robots that make maps of one name belong to one *joint map*, but each begins in a separate frame. Robots in one frame
exchange what they mapped; those in different frames are joined by places that they have both seen.
"""

from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import NamedTuple

from ppaas.clock import Clock, epoch, monotonic

LEAST = 30
"""Fewest key frames of a map that is joined with another; a merge needs places along 12 m of the drive."""

GROWTH, MORE = 1.2, 10
"""Factor, and number in addition, by which the key frames of refused maps must grow before they are tried again."""

EXCHANGE = 20
"""Number of new key frames of the robots in one frame after which they are exchanged."""

MERGE_PERIOD, EXCHANGE_PERIOD = 5.0, 15.0
"""Least time between two attempts to merge the same maps, and between two exchanges in one frame [s]."""

SILENT_PERIOD = 30.0
"""Time after which maps are tried again if one of their robots did not answer [s]."""

MOST_ROBOTS = 8
"""Largest number of robots in one frame."""


class RobotMap(NamedTuple):
    """Map of a robot.

    Parameters
    ----------
    user, robot : str
    frame : str
        Name of its map frame.
    key_frames, scans : int
        Numbers of its key frames, and of scans since it was begun.
    """

    user: str
    robot: str
    frame: str
    key_frames: int
    scans: int


class MapJoin(NamedTuple):
    """Maps to join.

    Parameters
    ----------
    joint_map : str
        Name of the joint map.
    groups : tuple of tuple of RobotMap
        One group of robots in one frame, which exchange what they mapped, or two; the result is in the frame of the
        first.
    """

    joint_map: str
    groups: tuple[tuple[RobotMap, ...], ...]

    @property
    def frames(self) -> frozenset[str]:
        """Frames of the groups."""
        return frozenset(group[0].frame for group in self.groups)

    @property
    def robots(self) -> list[RobotMap]:
        """All robots, the first group's first."""
        return [robot for group in self.groups for robot in group]

    @property
    def key_frames(self) -> int:
        """Sum of the numbers of key frames of its robots, when it was chosen."""
        return sum(robot.key_frames for robot in self.robots)

    @property
    def owner(self) -> str:
        """User on whose behalf the maps are joined."""
        return self.joint_map.partition("@")[2]


class Sharing(NamedTuple):
    """State of the map of a robot: alone, or part of a joint map.

    Parameters
    ----------
    joined_with : tuple of str
        Other robots in its frame.
    refused : str
        Why it was not joined with others at the last attempt; empty if it was, or nothing was tried.
    tried : float or None
        Time of that attempt [s since the epoch].
    """

    joined_with: tuple[str, ...] = ()
    refused: str = ""
    tried: float | None = None


ALONE = Sharing()


class _Tried(NamedTuple):
    """Maps of an attempt: frames of a joint map. Robots of another joint map may report frames of the same names."""

    joint_map: str
    frames: frozenset[str]


class _Attempt(NamedTuple):
    """Last attempt to join maps, with the number of their key frames then."""

    size: int
    at: float
    tried: float
    refused: str


class JoinSchedule:
    """Chooses the maps that are joined next: one join at once; the owner who waited longest is first.

    Parameters
    ----------
    clock, time : callable
        Return monotonic seconds, and seconds since the epoch.
    """

    def __init__(self, clock: Clock = monotonic, time: Clock = epoch) -> None:
        self._clock, self._time = clock, time
        self._maps: dict[str, list[RobotMap]] = {}
        self._attempts: dict[_Tried, _Attempt] = {}
        self._served: dict[str, float] = {}

    def report(self, maps: Mapping[str, Iterable[RobotMap]]) -> None:
        """Take the maps of all robots that map now, by the names of their joint maps; others are forgotten."""
        self._maps = {name: list(robots) for name, robots in maps.items()}
        frames = {name: {robot.frame for robot in robots} for name, robots in self._maps.items()}
        self._attempts = {
            tried: attempt
            for tried, attempt in self._attempts.items()
            if tried.frames <= frames.get(tried.joint_map, set())
        }
        owners = {name.partition("@")[2] for name in self._maps}
        self._served = {owner: at for owner, at in self._served.items() if owner in owners}

    def next_join(self) -> MapJoin | None:
        """Return the maps to join next; None if none are due."""
        due = [join for name, robots in self._maps.items() for join in self._due(name, robots)]
        return min(due, key=self._priority, default=None)

    def done(self, join: MapJoin, size: int, refused: str = "") -> None:
        """Note an attempt.

        Parameters
        ----------
        join : MapJoin
        size : int
            Sum of the numbers of key frames of its robots by now; 0 to try again after a while although they do not
            grow.
        refused : str
            Why the maps were not joined; empty if they were.
        """
        now = self._clock()
        self._served[join.owner] = now
        frames = join.frames if refused else frozenset((join.groups[0][0].frame,))
        self._attempts[_Tried(join.joint_map, frames)] = _Attempt(size, now, self._time(), refused)

    def sharing(self, user: str, robot: str) -> Sharing:
        """Return whether the map of a robot is part of a joint one, by the last report."""
        for name, robots in self._maps.items():
            for one in robots:
                if (one.user, one.robot) == (user, robot):
                    return self._sharing(one, name, robots)
        return ALONE

    def _sharing(self, one: RobotMap, name: str, robots: list[RobotMap]) -> Sharing:
        others = [other for other in robots if other.frame == one.frame and other is not one]
        names = tuple(shown_to(one.user, other) for other in others)
        attempts = [
            attempt
            for tried, attempt in self._attempts.items()
            if tried.joint_map == name and one.frame in tried.frames
        ]
        last = max(attempts, key=lambda attempt: attempt.at, default=None)
        return Sharing(names) if last is None else Sharing(names, last.refused, last.tried)

    def _due(self, name: str, robots: list[RobotMap]) -> Iterable[MapJoin]:
        frames: dict[str, list[RobotMap]] = {}
        for robot in robots:
            frames.setdefault(robot.frame, []).append(robot)
        groups = [tuple(group) for group in frames.values()]
        for group in groups:
            join = MapJoin(name, (group,))
            if len(group) > 1 and self._is_exchange_due(join):
                yield join
        for pair in combinations(groups, 2):
            older, younger = sorted(pair, key=_age, reverse=True)
            join = MapJoin(name, (older, younger))
            if len(join.robots) <= MOST_ROBOTS and self._is_merge_due(join):
                yield join

    def _is_exchange_due(self, join: MapJoin) -> bool:
        last = self._last(join)
        if last is None:
            return True
        return join.key_frames >= last.size + EXCHANGE and self._has_waited(last, EXCHANGE_PERIOD)

    def _is_merge_due(self, join: MapJoin) -> bool:
        if any(max(robot.key_frames for robot in group) < LEAST for group in join.groups):
            return False
        last = self._last(join)
        if last is None:
            return True
        return join.key_frames >= GROWTH * last.size + MORE and self._has_waited(last, MERGE_PERIOD)

    def _last(self, join: MapJoin) -> _Attempt | None:
        return self._attempts.get(_Tried(join.joint_map, join.frames))

    def _has_waited(self, last: _Attempt, period: float) -> bool:
        return self._clock() - last.at >= (period if last.size else SILENT_PERIOD)

    def _priority(self, join: MapJoin) -> tuple[float, float]:
        attempt = self._last(join)
        never = float("-inf")
        return self._served.get(join.owner, never), never if attempt is None else attempt.at


def shown_to(user: str, robot: RobotMap) -> str:
    """Return the name of a robot for a user."""
    return robot.robot if robot.user == user else f"{robot.user}/{robot.robot}"


def _age(group: tuple[RobotMap, ...]) -> tuple[int, str]:
    """Return the number of scans of a map, and its frame, so that the order is the same every time."""
    return max(robot.scans for robot in group), group[0].frame

"""Agreement of robots with each other and the map: offsets from people seen by several, evidence on each robot."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator.group import MemberRobot, prior_of
from ppaas.people.coordinator.people_table import PeopleTable, PersonRecord
from ppaas.people.coordinator.positions import jacobian_of
from ppaas.people.coordinator.sightings import Sightings
from ppaas.people.coordinator.visibility import PlacedView, Walls, visible_pairs
from ppaas.people.tracks.filter_bank import inverse_2x2

Array = NDArray[np.float64]

# -- agreement of robots -----------------------------------------------------------------------------------------------

OFFSETS_A_CYCLE = 5
"""Robots that a cycle compares with the others; the next cycle takes the next ones."""
CONFIRMS = 1.0
"""Distance to a person whom others see within which they confirm a torso of a robot that is not trusted [m]."""


def update_offsets(sightings: Sightings, now: float, turn: int) -> None:
    """Update the offsets of robots by the people whom other robots saw in the same cycle.

    Parameters
    ----------
    sightings : Sightings
    now : float
        [s]
    turn : int
        Number of the cycle, which decides whose turn it is.
    """
    shared = _shared(sightings)
    information, vectors = _all_together(sightings)
    rounds = -(-len(sightings.robots) // OFFSETS_A_CYCLE)
    for owner in range(turn % rounds, len(sightings.robots), rounds):
        robot, mine = sightings.robots[owner], shared & (sightings.owners == owner)
        robot.offset.predict(now, prior_of(robot.report))
        if mine.any():
            _compare(sightings, mine, robot, information, vectors)


def _shared(sightings: Sightings) -> NDArray[np.bool_]:
    """Return which torsos are of people whom another robot saw as well."""
    if not len(sightings.people):
        return np.zeros(0, np.bool_)
    shared: NDArray[np.bool_] = np.bincount(sightings.people)[sightings.people] > 1
    return shared


def _all_together(sightings: Sightings) -> tuple[Array, Array]:
    """Return the sums of the information of all torsos of a person, and of information times position, by person."""
    count = int(sightings.people.max(initial=-1)) + 1
    inverse, _ = inverse_2x2(sightings.covariances)
    information, vectors = np.zeros((count, 2, 2)), np.zeros((count, 2))
    np.add.at(information, sightings.people, inverse)
    np.add.at(vectors, sightings.people, (inverse @ sightings.positions[..., np.newaxis])[..., 0])
    return information, vectors


def _compare(
    sightings: Sightings, mine: NDArray[np.bool_], robot: MemberRobot, information: Array, vectors: Array
) -> None:
    """Update the offset of one robot by its torsos ``mine``, beside what the others alone report of the same people."""
    people, positions, covariances = sightings.people[mine], sightings.positions[mine], sightings.covariances[mine]
    own, _ = inverse_2x2(covariances)
    spread, _ = inverse_2x2(information[people] - own)
    rest = vectors[people] - (own @ positions[..., np.newaxis])[..., 0]
    others = (spread @ rest[..., np.newaxis])[..., 0]
    levers = positions - (robot.report.pose.x, robot.report.pose.y)
    residuals = positions - others + jacobian_of(levers) @ robot.offset.mean
    robot.offset.observe(levers, residuals, covariances + spread)


def settle(
    table: PeopleTable,
    robots: Mapping[str, MemberRobot],
    pair: tuple[PersonRecord, PersonRecord],
    difference: Array,
) -> set[str]:
    """Correct the offsets of robots that see one person at two positions, and all people whom only these robots see.

    The majority is right; of as many robots on both sides, the less certain ones are the likelier to be wrong.

    Parameters
    ----------
    table : PeopleTable
    robots : mapping of str to MemberRobot
    pair : pair of PersonRecord
        The one person as two.
    difference : (2,) array
        The position of the second minus the position of the first [m].

    Returns
    -------
    set of str
        The robots that were compared.
    """
    ones, others = (sorted(person.seen_by.keys() & robots.keys()) for person in pair)
    share = 1.0 if len(ones) > len(others) else 0.0
    if len(ones) == len(others):
        variances = [min((robots[name].uncertainty ** 2 for name in side), default=1.0) for side in (ones, others)]
        share = variances[1] / (variances[0] + variances[1])
    _shift(table, [robots[name] for name in others], share * difference)
    _shift(table, [robots[name] for name in ones], (share - 1.0) * difference)
    return {*ones, *others}


def _shift(table: PeopleTable, robots: Sequence[MemberRobot], error: Array) -> None:
    """Add an error [m] to the offsets of robots, and take it from the people whom they alone see."""
    if not error.any():
        return
    for robot in robots:
        robot.offset.mean = robot.offset.mean + np.append(error, 0.0)
        robot.offset.doubt(0.5 * float(np.hypot(*error)))
    names = {robot.name for robot in robots}
    rows = [row for row, person in enumerate(table.rows) if person.seen_by and person.seen_by.keys() <= names]
    table.bank.means[rows, :, :2] -= error
    table.read()


def compare_reports(
    table: PeopleTable, robots: Mapping[str, MemberRobot], denied_by: Mapping[int, Sequence[str]], seconds: float
) -> None:
    """Add evidence for and against each robot, from the people in its last report.

    Parameters
    ----------
    table : PeopleTable
    robots : mapping of str to MemberRobot
        The robots that report.
    denied_by : mapping of int to sequence of str
        The robots that should see a person and do not, by the row of the person.
    seconds : float
        Time that this evidence counts for [s].
    """
    counts: dict[str, list[int]] = {name: [0, 0] for name in robots}
    witnesses: dict[str, set[str]] = {name: set() for name in robots}
    for row, person in enumerate(table.rows):
        deny = denied_by.get(row, ())
        alone = len(person.seen_by) == 1
        for name in person.seen_by:
            if not alone:
                counts[name][0] += 1
            elif deny:
                counts[name][1] += 1
                witnesses[name] |= set(deny)
        change = len(deny) - 1 if alone and len(deny) > 1 else -1
        person.doubt = min(max(person.doubt + seconds * change, 0.0), 4.0)
    for name, robot in robots.items():
        if robot.trust.trusted:
            confirmed, denied = counts[name]
            robot.trust.compare(seconds, confirmed=confirmed, denied=denied, witnesses=sorted(witnesses[name]))


def compare_distrusted(
    table: PeopleTable, robot: MemberRobot, deny: Mapping[int, Sequence[str]], seconds: float
) -> None:
    """Add evidence for and against a robot that is not trusted, by the distances to the people whom others see.

    Parameters
    ----------
    table : PeopleTable
    robot : MemberRobot
    deny : mapping of int to sequence of str
        The robots that should see each of its torsos, by number.
    seconds : float
        Time that this evidence counts for [s].
    """
    seen = [row for row, person in enumerate(table.rows) if person.seen_by]
    confirmed, denied, witnesses = 0, 0, set[str]()
    for number, torso in enumerate(robot.torsos()):
        off = table.positions[seen] - torso
        if len(off) and np.hypot(off[:, 0], off[:, 1]).min() < CONFIRMS:
            confirmed += 1
        elif deny.get(number):
            denied += 1
            witnesses |= set(deny[number])
    robot.trust.compare(seconds, confirmed=confirmed, denied=denied, witnesses=sorted(witnesses))


# -- comparison of the robots of a group with the map and with each other, which decides whose reports are used --------

WITNESSES_A_CYCLE = 5
"""Robots whose views a cycle compares with the people whom others see; the next cycle takes the next ones."""
BEHIND = 1.0
"""Distance behind a wall from which a robot cannot see a person, apart from its deviation [m]."""


class RobotComparison:
    """Comparison of the robots in one cycle.

    Parameters
    ----------
    table : PeopleTable
    robots : mapping of str to MemberRobot
        The robots that report.
    views : sequence of PlacedView
        Views of those that are trusted, numbered as in the sorted names of ``robots``.
    walls : Walls
    bodies : (M, 2) array
        Positions of the people who may hide others [m].
    radius : float
        Radius of their bodies [m].
    """

    def __init__(
        self, table: PeopleTable, robots: Mapping[str, MemberRobot], views: Sequence[PlacedView], walls: Walls, *,
        bodies: Array, radius: float,
    ) -> None:  # fmt: skip
        self._table, self._robots, self._names = table, robots, sorted(robots)
        self._views, self._walls = views, walls
        self._bodies, self._radius = bodies, radius

    def judge(self, turn: int, seconds: float) -> None:
        """Add evidence for and against each robot, and decide which ones are trusted.

        Parameters
        ----------
        turn : int
            Number of the comparison, which decides whose views are used.
        seconds : float
            Time since the last comparison [s].
        """
        for robot in self._robots.values():
            robot.trust.forget(seconds)
        trusted = sorted({view.robot for view in self._views})
        rounds = max(1, math.ceil(len(trusted) / WITNESSES_A_CYCLE))
        witnesses = set(trusted[turn % rounds :: rounds])
        for number, name in enumerate(self._names):
            if number in witnesses or not self._robots[name].trust.trusted:
                self._compare_with_map(self._robots[name], rounds * seconds if number in witnesses else seconds)
        compare_reports(self._table, self._robots, self._denied_by(witnesses), rounds * seconds)
        reliable = {name for name in self._names if self._robots[name].trust.reliable}
        for name in self._names:
            robot = self._robots[name]
            if not robot.trust.trusted:
                compare_distrusted(self._table, robot, self._deny_torsos(robot), seconds)
            robot.trust.judge(reliable - {name})

    def _compare_with_map(self, robot: MemberRobot, seconds: float) -> None:
        """Add evidence for and against a robot: its people in walls, or so far behind that it cannot see them."""
        robot.trust.see(seconds, walled=robot.report.outside, clear=0)
        if len(robot.world):
            pose = robot.report.pose
            clear = self._walls.free_between(np.array([pose.x, pose.y]), robot.world, BEHIND + robot.deviation)
            robot.trust.see(seconds, walled=int((~clear).sum()), clear=int(clear.sum()))

    def _denied_by(self, witnesses: set[int]) -> dict[int, list[str]]:
        """Return the witnesses that should see a person and do not, by the row of the person."""
        views = [view for view in self._views if view.robot in witnesses]
        seen = [row for row, person in enumerate(self._table.rows) if person.seen_by]
        denied_by: dict[int, list[str]] = {}
        for number, row in self._visible(views, self._table.positions, seen):
            if self._names[number] not in self._table.rows[row].seen_by:
                denied_by.setdefault(row, []).append(self._names[number])
        return denied_by

    def _deny_torsos(self, robot: MemberRobot) -> dict[int, list[str]]:
        """Return the robots that should see each torso of one that is not trusted, by number."""
        torsos = robot.torsos()
        deny: dict[int, list[str]] = {}
        for number, torso in self._visible(self._views, torsos, range(len(torsos))):
            deny.setdefault(torso, []).append(self._names[number])
        return deny

    def _visible(self, views: Sequence[PlacedView], people: Array, wanted: Sequence[int]) -> list[tuple[int, int]]:
        if not views or not wanted:
            return []
        return visible_pairs(views, self._walls, people, wanted, self._bodies, radius=self._radius)

"""Coordinator: reports of robots in, identities, a count and orders to follow out.

A cycle has the five steps of the paper's case study: the maximum position deviation of each robot
(`robots.deviation`), all torsos in the world frame (`robots.world_frame`), identical persons recognized and counted
(`identities`), the Follow Action Controller (`follow_action`) and the rule for switching robots (`switch_rule`).
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, PeopleReport, PeopleState, ZoneCount
from ppaas.people.coordinator import agreement
from ppaas.people.coordinator.agreement import RobotComparison
from ppaas.people.coordinator.cost_fields import PathCosts
from ppaas.people.coordinator.duplicates import Duplicates
from ppaas.people.coordinator.follow_controller import FollowController, FollowScene
from ppaas.people.coordinator.group import MOST_ROBOTS, MemberRobot, Robots
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import MOST_PEOPLE, PeopleTable, PersonRecord
from ppaas.people.coordinator.reports import Report, detected_twice, read_report
from ppaas.people.coordinator.sightings import observe
from ppaas.people.coordinator.state import load_state, save_state, state_of
from ppaas.people.coordinator.visibility import (
    MapArea,
    PlacedView,
    Walls,
    hidden_by_people,
    in_views,
    view_of,
    visible_pairs,
)
from ppaas.people.coordinator.zone_counts import ZoneCounts
from ppaas.people.rules.base import Candidate
from ppaas.people.rules.registry import create
from ppaas.people.settings import PeopleSettings
from ppaas.planar_poses import moved_points

Array = NDArray[np.float64]
# -- contradictions between identities ---------------------------------------------------------------------------------

Mask = NDArray[np.bool_]


class Contradictions:
    """Finds the pairs of people of which some robot of either should see the other, in one cycle.

    Parameters
    ----------
    table : PeopleTable
    robots : sequence of str
        Robot IDs, by the numbers of the views.
    views : sequence of PlacedView
    walls : Walls
    radius : float
        Radius of people who hide others [m].
    """

    def __init__(
        self, table: PeopleTable, robots: Sequence[str], views: Sequence[PlacedView], walls: Walls, radius: float
    ) -> None:
        self._table, self._views, self._walls, self._radius = table, views, walls, radius
        self._within = in_views(views, table.positions)
        self._views_of: dict[str, list[int]] = {}
        for number, view in enumerate(views):
            self._views_of.setdefault(robots[view.robot], []).append(number)
        self._present = np.array(table.present, np.intp)

    def __call__(self, pairs: Sequence[tuple[int, int]]) -> list[bool]:
        """Return for each pair of rows whether some robot of either should see the other; both do not hide anybody."""
        lines = [self._lines(a, b) + self._lines(b, a) for a, b in pairs]
        counts = [len(each) for each in lines]
        views, targets, seers = (np.array([line for each in lines for line in each], np.intp).reshape(-1, 3)).T
        seen = self._clear(views, targets, seers)
        found = []
        for (a, b), start, count in zip(pairs, np.cumsum([0, *counts]).tolist(), counts, strict=False):
            shown = set(targets[start : start + count][seen[start : start + count]].tolist())
            found.append(shown == {a, b})
        return found

    def _lines(self, seen: int, other: int) -> list[tuple[int, int, int]]:
        """Return view, target and person seen for each view with the other of the robots that see one person."""
        views = [view for robot in self._table.rows[seen].seen_by for view in self._views_of.get(robot, ())]
        return [(view, other, seen) for view in views if self._within[view, other]]

    def _clear(self, views: NDArray[np.intp], targets: NDArray[np.intp], seers: NDArray[np.intp]) -> Mask:
        """Return on which lines from views to targets neither a wall nor a third person is."""
        origins = np.array([self._views[view].pose[:2] for view in views.tolist()]).reshape(-1, 2)
        points, bodies = self._table.positions[targets], self._table.positions[self._present]
        apart = (self._present == targets[:, np.newaxis]) | (self._present == seers[:, np.newaxis])
        clear = self._walls.free_between(origins, points)
        clear[clear] = ~hidden_by_people(origins[clear], points[clear], bodies, self._radius, apart[clear])
        return clear


# -- presence of people ------------------------------------------------------------------------------------------------

MISSED = 0.9
"""Evidence that a person loses for each cycle in which a robot with a new report should see them and does not."""
SPREAD = 1.0
"""Standard deviation that is added to the position of a person who is not where predicted [m]."""
UNCONFIRMED = 1.0
"""Time without a sighting after which a person who was never confirmed is forgotten [s]."""


def update_presence(
    table: PeopleTable,
    missed_by: Mapping[int, Collection[bool]],
    seconds: float,
    now: float,
    parameters: CoordinatorParameters,
) -> None:
    """Update the states of all people.

    Parameters
    ----------
    table : PeopleTable
    missed_by : mapping of int to collection of bool
        Of people without a sighting in this cycle, by row: for each robot that should see them whether its report is
        new. An empty collection means that they are hidden from all robots.
    seconds : float
        Time since the last cycle [s].
    now : float
        [s]
    parameters : CoordinatorParameters
    """
    for row, person in enumerate(table.rows):
        missing = missed_by.get(row, ())
        if any(missing) and not person.seen_by:
            person.evidence -= MISSED
        before = person.state
        person.state = _state(person, bool(missing), now, parameters)
        if person.state == SEEN:
            person.seen_total += seconds
        elif person.state == LOST and before != LOST:
            table.bank.covariances[row, :, :2, :2] += SPREAD**2 * np.eye(2)


def _state(person: PersonRecord, in_view: bool, now: float, parameters: CoordinatorParameters) -> str:
    """Return the state of a person.

    A person whom the robots just saw, and who is still in somebody's view, counts as seen: detectors miss people now
    and then. A person who is hidden is predicted. One who should be seen and is not has left.
    """
    hidden = now - person.last_seen
    if person.seen_by or (in_view and hidden <= parameters.seen_for and person.evidence > 0.0):
        return SEEN
    if person.evidence <= 0.0 or hidden > parameters.predict_for or person.state == LOST:
        return LOST
    return PREDICTED


def forgotten(table: PeopleTable, now: float, parameters: CoordinatorParameters, most: int) -> set[int]:
    """Return the rows of people to forget: hidden for too long, never confirmed, or more than the table holds."""
    gone = set()
    for row, person in enumerate(table.rows):
        hidden = now - person.last_seen
        limit = parameters.forget_after if person.confirmed else UNCONFIRMED
        if hidden > limit or (not person.confirmed and person.evidence <= 0.0):
            gone.add(row)
    surplus = len(table) - len(gone) - most
    if surplus > 0:
        rest = sorted(set(range(len(table))) - gone, key=lambda row: (table.rows[row].last_seen, -table.rows[row].id))
        gone |= set(rest[:surplus])
    return gone


# -- the coordinator: reports in, identities, a count and orders to follow out -----------------------------------------

SET_BACK = 1.0
"""Lateness of a time from which the clock was set back [s]."""
LONGEST_STEP = 5.0
"""Limit of the time that people are predicted at once [s]."""
OUTSIDE = 0.5
"""Distance from the free space of the map beyond which nobody is, apart from the deviation of the robot [m]."""
LATE = 5.0
"""Timeouts of reports after which a robot loses its orders."""
FIRST_COSTS = 2.0
"""Time that orders wait for the costs of all people [s]."""


class PeopleCoordinator:
    """Coordinates the robots of a group on a map.

    Parameters
    ----------
    costmap : Costmap
        Map with inflated obstacles.
    settings : PeopleSettings, optional
    parameters : CoordinatorParameters, optional

    Attributes
    ----------
    at, began : float
        Times of the last and the first cycle [s since the epoch]; −∞ before.

    Raises
    ------
    NotFound
        The rule of the settings is not installed.
    """

    def __init__(
        self,
        costmap: Costmap,
        settings: PeopleSettings | None = None,
        parameters: CoordinatorParameters | None = None,
    ) -> None:
        self.parameters = CoordinatorParameters() if parameters is None else parameters
        self.settings = PeopleSettings() if settings is None else settings
        self._rule = create(self.settings.rule)
        self.table = PeopleTable()
        self.robots = Robots(self.parameters.deviation_history)
        self.follow = FollowController(self.parameters)
        self.zones = ZoneCounts(self.settings)
        self._duplicates = Duplicates()
        self._walls, self._area = Walls(costmap), MapArea(costmap)
        self._costs = PathCosts(costmap, self.parameters.cells_per_cycle)
        self.at = self.began = -math.inf
        self._turn = 0
        self._present: list[int] = []

    def use_costmap(self, costmap: Costmap) -> None:
        """Replace the map; identities and orders are kept."""
        self._walls, self._area = Walls(costmap), MapArea(costmap)
        self._costs.use_costmap(costmap)

    def configure(self, settings: PeopleSettings) -> None:
        """Replace the settings.

        Raises
        ------
        NotFound
            The rule is not installed; the settings are unchanged.
        """
        self._rule = create(settings.rule)
        self.settings = settings
        self.zones.configure(settings)

    def report(self, report: PeopleReport, now: float) -> None:
        """Take a report of a robot, which the next step uses.

        Parameters
        ----------
        report : PeopleReport
        now : float
            Time of arrival [s since the epoch].

        Raises
        ------
        InvalidInput
            A number is not finite or out of range; nothing has changed.
        """
        read = read_report(report)
        self._follow_clock(now)
        if read.robot not in self.robots.known and len(self.robots.known) >= MOST_ROBOTS:
            raise InvalidInput(f"a group may have up to {MOST_ROBOTS} robots; {read.robot!r} is one more")
        self.robots.take(self._usable(read), now)

    def _usable(self, report: Report) -> Report:
        """Return a report without torsos outside the free space of the map, as in mirrors, and second torsos."""
        if not report.ids:
            return report
        known = self.robots.known.get(report.robot)
        report = report.without(detected_twice(report, known.bound if known is not None else {}))
        positions = moved_points(report.pose, report.torsos)
        if known is not None:
            positions = known.offset.corrected(positions, (report.pose.x, report.pose.y))
        left_out = self._area.distance(positions) > OUTSIDE + report.deviation
        return report.without(left_out, int(left_out.sum()))

    def step(self, now: float) -> PeopleState:
        """Run a cycle.

        Parameters
        ----------
        now : float
            [s since the epoch]

        Returns
        -------
        PeopleState
            ``seconds`` is 0: a caller with a clock sets it.
        """
        self._follow_clock(now)
        seconds = min(max(now - self.at, 0.0), LONGEST_STEP) if math.isfinite(self.at) else 0.0
        self.began = now if not math.isfinite(self.at) else self.began
        self.at, self._turn = now, self._turn + 1
        self.robots.forget(now - self.parameters.robot_timeout)
        self.table.predict(seconds)
        reporting = {
            name: robot for name, robot in self.robots.known.items()
            if now - robot.arrived <= self.parameters.report_timeout and not robot.is_frozen
        }  # fmt: skip
        self._recognize(reporting, now)
        views = self._views(reporting)
        self._present = self.table.present
        self._update_presence(views, seconds, now)
        if self._turn % 2:
            self._merge(reporting, views, now)
        else:
            comparison = RobotComparison(
                self.table, reporting, views, self._walls,
                bodies=self.table.positions[self._present], radius=self.parameters.body_radius,
            )  # fmt: skip
            comparison.judge(self._turn // 2, 2.0 * seconds)
        self.table.drop(forgotten(self.table, now, self.parameters, MOST_PEOPLE))
        update_groups(self.table, now, self._free_between)
        self._count_zones(now)
        self._follow(reporting, now)
        return state_of(self, now)

    def counts(self, since: int) -> list[ZoneCount]:
        """Return the counts of the hours that ended after a time [s since the epoch]; none without history."""
        return self.zones.since(since)

    def checkpoint(self) -> bytes:
        """Return the state, with which another coordinator goes on."""
        return save_state(self)

    def restore(self, saved: bytes) -> None:
        """Go on from a checkpoint; robots join again by their next reports.

        Raises
        ------
        InvalidInput
            It is not a checkpoint of a coordinator; nothing has changed.
        """
        load_state(self, saved)

    def _follow_clock(self, now: float) -> None:
        """Move all times by that by which the clock was set back, if it was: ages stay the same."""
        seconds = now - self.at
        if math.isfinite(seconds) and seconds < -SET_BACK:
            for part in (self.table, self.robots, self.follow, self._duplicates):
                part.move_times(seconds)
            self.at, self.began = now, self.began + seconds

    def _recognize(self, reporting: Mapping[str, MemberRobot], now: float) -> None:
        """Steps 1 to 3: torsos in the world frame become people; robots that see the same people are compared."""
        used = {name: robot for name, robot in reporting.items() if robot.trust.trusted}
        fresh = [robot for robot in used.values() if robot.fresh]
        if fresh:
            agreement.update_offsets(observe(self.table, fresh, now, self.parameters), now, self._turn)
        row_of = self.table.row_of()
        for person in self.table.rows:
            person.seen_by.clear()
        for name in sorted(used):
            robot = used[name]
            for torso, frame in zip(robot.report.ids, robot.report.frames, strict=True):
                row = row_of.get(robot.bound.get(torso, 0))
                if row is not None:
                    self.table.rows[row].seen_by[name] = frame

    def _views(self, reporting: Mapping[str, MemberRobot]) -> list[PlacedView]:
        """Return the views of the robots that are trusted, numbered as in the sorted names of ``reporting``."""
        return [
            view_of(number, robot.pose, view)
            for number, robot in enumerate(reporting[name] for name in sorted(reporting))
            if robot.trust.trusted
            for view in robot.report.views
        ]

    def _update_presence(self, views: list[PlacedView], seconds: float, now: float) -> None:
        unseen = [row for row, person in enumerate(self.table.rows) if not person.seen_by and person.state != LOST]
        missed_by: dict[int, list[bool]] = {}
        for _, row in self._visible(views, unseen):
            missed_by.setdefault(row, []).append(True)
        update_presence(self.table, missed_by, seconds, now, self.parameters)

    def _visible(self, views: list[PlacedView], wanted: list[int]) -> list[tuple[int, int]]:
        """Return the pairs of robot and row of which the robot should see the person."""
        if not wanted or not views:
            return []
        bodies = self.table.positions[self._present]
        return visible_pairs(
            views, self._walls, self.table.positions, wanted, bodies, radius=self.parameters.body_radius
        )

    def _merge(self, reporting: Mapping[str, MemberRobot], views: list[PlacedView], now: float) -> None:
        """Join identities that are one person, and correct the offsets of the robots that disagreed."""
        contradict = Contradictions(self.table, sorted(reporting), views, self._walls, self.parameters.body_radius)
        pairs = self._duplicates.find(self.table, now, contradict)
        settled = set[str]()
        for kept, dropped in pairs:
            row_of = self.table.row_of()
            one, other = self.table.rows[row_of[kept]], self.table.rows[row_of[dropped]]
            if settled.isdisjoint(one.seen_by) and settled.isdisjoint(other.seen_by):
                difference = self.table.positions[row_of[dropped]] - self.table.positions[row_of[kept]]
                settled |= agreement.settle(self.table, reporting, (one, other), difference)
                self._duplicates.forget(settled)
            self._join(kept, dropped)
        self._present = self.table.present

    def _join(self, kept: int, dropped: int) -> None:
        """Make two identities one, the older."""
        row_of = self.table.row_of()
        one, other = self.table.rows[row_of[kept]], self.table.rows[row_of[dropped]]
        if len(other.seen_by) > len(one.seen_by):
            self.table.bank.copy(row_of[dropped], row_of[kept])
        one.seen_by |= other.seen_by
        one.first_seen = min(one.first_seen, other.first_seen)
        for robot in self.robots.known.values():
            robot.bound = {torso: kept if person == dropped else person for torso, person in robot.bound.items()}
        self.zones.merge(kept, dropped)
        self.follow.merge(kept, dropped)
        self.table.drop({row_of[dropped]})

    def _free_between(self, one: Array, other: Array) -> bool:
        return bool(self._walls.free_between(one, other[np.newaxis], 0.1)[0])

    def _count_zones(self, now: float) -> None:
        if self.settings.history:
            rows = [row for row, person in enumerate(self.table.rows) if person.counts]
            at = self.table.positions[rows].tolist()
            self.zones.add({self.table.rows[row].id: (x, y) for row, (x, y) in zip(rows, at, strict=True)}, now)

    def _follow(self, reporting: Mapping[str, MemberRobot], now: float) -> None:
        """Steps 4 and 5: costs, targets by the rule, and orders."""
        able = {name for name, robot in reporting.items() if robot.report.can_follow and robot.trust.trusted}
        wanted = {*self.follow.orders, *self.settings.targets}
        rows = {
            person.id: row for row, person in enumerate(self.table.rows)
            if person.confirmed and (person.seen_by or person.id in wanted)
        }  # fmt: skip
        seen = {each: set(self.table.rows[row].seen_by) & able for each, row in rows.items()}
        orders = self.follow.orders
        wanting = {each: names | ({orders[each].robot} & able if each in orders and names else set())
                   for each, names in seen.items() if self.table.rows[rows[each]].counts}  # fmt: skip
        pairs = {(name, each) for each, names in wanting.items() for name in names}
        where = {each: (float(x), float(y)) for each, row in rows.items() for x, y in [self.table.positions[row]]}
        robots = {name: (pose.x, pose.y) for name in able for pose in [reporting[name].pose]}
        followed = sorted(self.follow.orders)
        fresh = self._costs.update(robots, where, pairs, followed)
        waits = len(self._costs.costs) < len(pairs) and now - self.began < FIRST_COSTS
        costs = self._costs.by_person()
        candidates = self._candidates(rows, costs)
        limit = self.settings.followed_at_once
        targets = [] if waits else self._rule.choose(candidates, self.settings.targets, limit)[:limit]
        reasons = {each.person: self._rule.reason(each) for each in candidates if each.person in set(targets)}
        known = self.robots.known
        following = {name: robot.report.following for name, robot in known.items()}
        kept = {name for name, robot in known.items() if self._keeps_orders(robot, now)}
        self.follow.update(FollowScene(now, targets, seen, costs, fresh, able, kept, following, reasons))

    def _keeps_orders(self, robot: MemberRobot, now: float) -> bool:
        """Return whether a robot that has orders may keep them: its reports may be late for a while."""
        late = now - robot.arrived > LATE * self.parameters.report_timeout
        return robot.report.can_follow and robot.trust.trusted and not late

    def _candidates(self, rows: Mapping[int, int], costs: Mapping[int, Mapping[str, float]]) -> list[Candidate]:
        """Return those who can be followed: whom robots see, whom they follow, and whom a user picked."""
        candidates = []
        for each, row in rows.items():
            person = self.table.rows[row]
            reached = {name: cost for name, cost in costs.get(each, {}).items() if math.isfinite(cost)}
            name = self.settings.names.get(str(each), "")
            followed = each in self.follow.orders
            candidates.append(Candidate(each, reached, person.first_seen, person.seen_total, followed, name))
        return candidates


# -- groups of people who stand together and talk ----------------------------------------------------------------------

NEAR = 1.6
"""Distance between two who talk: the social distance of Hall (The Hidden Dimension, 1966) begins at 1.2 m [m]."""
STILL = 0.3
"""Speed below which a person stands [m/s]."""
LASTS = 3.0
"""Time for which people must have stood [s]."""

FreeBetween = Callable[[Array, Array], bool]
"""Called with two positions [m]; whether no wall is between them."""


def update_groups(table: PeopleTable, now: float, free_between: FreeBetween) -> None:
    """Update who stands together: each group is numbered by the least id in it, others get 0.

    Parameters
    ----------
    table : PeopleTable
    now : float
        [s]
    free_between : callable
        See `FreeBetween`.
    """
    speeds = np.hypot(table.velocities[:, 0], table.velocities[:, 1])
    present = set(table.present)
    for row, person in enumerate(table.rows):
        person.group = 0
        if row not in present or speeds[row] > STILL:
            person.still_since = float("inf")
        else:
            person.still_since = min(person.still_since, now)
    still = [row for row in sorted(present) if now - table.rows[row].still_since >= LASTS]
    for members in _together(table.positions, still, free_between):
        number = min(table.rows[row].id for row in members)
        for row in members:
            table.rows[row].group = number


def _together(positions: Array, rows: list[int], free_between: FreeBetween) -> list[list[int]]:
    """Return the sets of two or more rows that are connected by steps of less than `NEAR`."""
    at = positions[rows]
    x, y = at[:, 0, np.newaxis] - at[:, 0], at[:, 1, np.newaxis] - at[:, 1]
    leader = list(range(len(rows)))

    def lead(k: int) -> int:
        while leader[k] != k:
            k = leader[k]
        return k

    for i, k in np.argwhere(np.triu(x * x + y * y < NEAR * NEAR, 1)).tolist():
        if lead(i) != lead(k) and free_between(at[i], at[k]):
            leader[lead(k)] = lead(i)
    groups: dict[int, list[int]] = {}
    for k, row in enumerate(rows):
        groups.setdefault(lead(k), []).append(row)
    return [members for members in groups.values() if len(members) > 1]

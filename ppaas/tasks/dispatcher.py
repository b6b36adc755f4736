"""Dispatcher: leads the tasks of a user on a map from the queue to their end, as a state machine with orders.

Each leg of a task is one goal of Move Base. Its id follows from the record of the task, which is stored before the goal
is sent. So a dispatcher that is made from the stored records goes on where an earlier one was killed: it sends the same
goals again, and Move Base ignores those that it has.
"""

import math
from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from types import MappingProxyType
from typing import Any

from msgspec.structs import replace

from ppaas.energy.sites import NO_SITES, Sites
from ppaas.tasks.assignment import Distance, TaskRobot, assign, may_do
from ppaas.tasks.charging import is_charged, leavers, must_charge, other_reason, reach_reason, trips
from ppaas.tasks.orders import Cancel, Order, Outcome, RobotNow, Send, StoreTask
from ppaas.tasks.reach import remaining, straight
from ppaas.tasks.records import GOALS, Place, Task, TaskState
from ppaas.tasks.succession import following, verdict
from ppaas.tasks.ways import NO_WAY, with_way_reasons

# -- dispatcher --------------------------------------------------------------------------------------------------------

MOST_FAILURES = 3
"""Number of times that robots may fail a task; then it has failed."""

REST = 15.0
"""Time for which a robot that failed a task gets no other one [s]."""

GONE_AFTER = 30.0
"""Time from the loss of a robot's connection until it gives its task back [s]."""


class Dispatcher:
    """State machine of the tasks of a user on a map. Its methods are events; they return orders, to be obeyed in turn.

    Parameters
    ----------
    tasks : iterable of Task
        Stored tasks; of those that have ended, others may wait for the end.
    now : float
        Time [s since the epoch], as everywhere here.

    Attributes
    ----------
    sites : Sites
        Where robots charge and park; they do neither on a map without such places.
    """

    def __init__(self, tasks: Iterable[Task], now: float) -> None:
        self.sites: Sites = NO_SITES
        self._tasks: dict[str, Task] = {}
        self._task_of: dict[str, str] = {}
        self._ended: dict[str, TaskState] = {}
        self._robots: dict[str, RobotNow] = {}
        self._seen: dict[str, float] = {}
        self._rests_until: dict[str, float] = {}
        for task in tasks:
            self.add(task, now)

    @property
    def tasks(self) -> Mapping[str, Task]:
        """Tasks that have not ended, by id."""
        return self._tasks

    @property
    def away(self) -> list[str]:
        """Robots that have a task and are not connected."""
        return [robot for robot in self._task_of if robot not in self._robots]

    # -- events --------------------------------------------------------------------------------------------------------

    def add(self, task: Task, now: float) -> None:
        """Note a stored task; nothing changes by one that is known."""
        if not task.is_open:
            self._ended.setdefault(task.id, task.state)
        if not task.is_open or task.id in self._tasks:
            return
        self._tasks[task.id] = task
        if task.robot:
            self._task_of[task.robot] = task.id
            self._seen.setdefault(task.robot, now)

    def keep_ends(self, known: Mapping[str, TaskState]) -> None:
        """Note how tasks have ended that are still stored, and forget all others."""
        self._ended = dict(known)

    def confirm(self, task: Task) -> None:
        """Note a stored task that was confirmed since; its robot goes on with the next ``release``."""
        self._tasks[task.id] = task

    def withdraw(self, task_id: str) -> list[Order]:
        """Forget a task whose record says that it was cancelled; its robot stops."""
        task = self._tasks.pop(task_id, None)
        if task is None or not task.robot:
            return []
        del self._task_of[task.robot]
        return [Cancel(task.robot, task.goal_id)]

    def see(
        self,
        robots: Mapping[str, RobotNow],
        now: float,
        lost: Mapping[str, float] = MappingProxyType({}),
        riding: AbstractSet[str] = frozenset(),
    ) -> list[Order]:
        """Note the robots that are connected: all of them, each time.

        Parameters
        ----------
        robots : mapping of str to RobotNow
        now : float
        lost : mapping of str to float
            Times at which others were lost, as far as known; by default, since they were not seen any more.
        riding : set of str
            Robots in lifts, where they may be silent: they keep their tasks.
        """
        come = [name for name in robots if name not in self._robots]
        self._robots = dict(robots)
        orders: list[Order] = []
        for name, robot in robots.items():
            self._seen[name] = now
            task = self._task(name)
            strays = {goal.partition("/")[0] for goal in robot.goals if goal.startswith(GOALS)}
            strays -= {"" if task is None else task.goal_id}
            orders += [Cancel(name, goal) for goal in sorted(strays)]
        come_tasks = [task for name in come if (task := self._task(name)) is not None]
        orders += [self._send(task) for task in come_tasks if task.holding is None]
        for name in self._seen.keys() & lost.keys() - robots.keys():
            self._seen[name] = min(self._seen[name], lost[name])
        self._seen |= dict.fromkeys(self._seen.keys() & riding, now)
        for name in tuple(self._seen):
            if now - self._seen[name] > GONE_AFTER:
                orders += self._gone(name, now)
        return orders

    def goal_ended(self, robot: str, goal_id: str, outcome: Outcome, text: str, now: float) -> list[Order]:
        """Note the end of a goal; a goal that is not of the robot's task changes nothing.

        The clone of a robot that is away may give a goal up. That is no failure: it is sent again if the robot comes
        back in time.
        """
        task = self._task(robot)
        if task is None or task.goal_id != goal_id or task.holding is not None:
            return []
        if outcome == "succeeded":
            return self._arrived(task, now)
        reason = f"robot {robot!r}: goal {outcome}" + (f": {text}" if text else "")
        if robot not in self._robots and outcome in {"aborted", "lost"}:
            return self._store(replace(task, attempt=task.attempt + 1, reason=reason))
        if outcome == "lost" and task.failures + 1 < MOST_FAILURES:
            again = replace(task, attempt=task.attempt + 1, failures=task.failures + 1, reason=reason)
            return [*self._store(again), self._send(again)]
        self._rests_until[robot] = now + REST
        return self._failed(task, reason, now)

    def decide(self, now: float, distance: Distance = straight) -> list[Order]:
        """Give tasks to robots, or to others if that pays; tasks whose deadline has passed fail.

        Parameters
        ----------
        now : float
        distance : callable
            Returns the length of the way between two places [m].
        """
        orders = self._end_hopeless(now) + self._leave_chargers(now)
        free, tasks = self.candidates(now), self.undecided(now)
        if free and tasks:
            found = assign(free, tasks, distance, now, self.sites)
            busy = {candidate.robot for candidate in free if candidate.remaining > 0.0}
            moved = [
                (task, robot)
                for task in tasks
                if (robot := _unless(found.get(task.id, ""), busy)) != task.robot
            ]  # fmt: skip
            orders += self._move(moved, now)
            for task in with_way_reasons(self.undecided(now), free, distance):
                orders += self._store(task)
        return orders + self._preempt(now, distance) + self._rest(now)

    def release(self, now: float) -> list[Order]:
        """Send robots on whose hold was confirmed, or has lasted for its time."""
        orders: list[Order] = []
        for task in tuple(self._tasks.values()):
            hold, since = task.hold, task.holding
            if hold is None or since is None:
                continue
            over = hold.seconds is not None and now - since >= hold.seconds
            charged = is_charged(task, self._robots.get(task.robot))
            if over or charged or (hold.is_confirmed and task.confirmed == task.leg):
                orders += self._go_on(task, now)
        return orders

    # -- what there is to decide ---------------------------------------------------------------------------------------

    def candidates(self, now: float) -> list[TaskRobot]:
        """Return the robots that may begin a task now, or after the one that they keep."""
        found = []
        for name, robot in sorted(self._robots.items()):
            if robot.place is None or robot.is_led or now < self._rests_until.get(name, now):
                continue
            task = self._task(name)
            if task is None or (task.state == "assigned" and task.trip != "charge"):
                found.append(TaskRobot(name, robot.place, 0.0, robot.labels, robot.battery))
            elif task.trip != "charge":
                left = remaining(task, robot.place)
                found.append(TaskRobot(name, task.stops[-1], left, robot.labels, robot.battery))
        return found

    def undecided(self, now: float) -> list[Task]:
        """Return the tasks that a robot may get now: those without a robot, and those that theirs has not begun."""
        free = {candidate.robot for candidate in self.candidates(now)}
        return [
            task
            for task in self._tasks.values()
            if task.trip != "charge" and (self._may_begin(task, now) if not task.robot else _may_move(task, free))
        ]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _may_begin(self, task: Task, now: float) -> bool:
        return now >= task.may_start and verdict(task, self._ended, self._tasks)[0] == "ready"

    def _end_hopeless(self, now: float) -> list[Order]:
        """End the tasks that no robot can begin any more."""
        orders: list[Order] = []
        for task in tuple(self._tasks.values()):
            if not task.robot and task.trip:
                orders += self._end(task, "cancelled", task.reason, now)
            if task.robot or task.begun is not None or task.trip:
                continue
            known, reason = verdict(task, self._ended, self._tasks)
            if known == "never":
                orders += self._end(task, "cancelled", reason, now)
            elif task.deadline is not None and now > task.deadline:
                orders += self._end(task, "failed", "no robot could begin it before its deadline", now)
        return orders

    def _leave_chargers(self, now: float) -> list[Order]:
        """End charging early where others need the charger, or tasks wait."""
        waiting = [task for task in self.undecided(now) if not task.robot]
        orders: list[Order] = []
        for robot in leavers(self._robots, self._tasks_of(), self.sites, waiting, now):
            orders += self._end(self._tasks[self._task_of[robot]], "done", "", now)
        return orders

    def _rest(self, now: float) -> list[Order]:
        """Send robots to chargers and parking spots, and report tasks for which no battery lasts."""
        if not self.sites.chargers and not self.sites.parking:
            return []
        waiting = [task for task in self.undecided(now) if not task.robot]
        orders: list[Order] = []
        for task in waiting:
            reason = reach_reason(task, self._robots, self.sites)
            orders += [] if reason == task.reason else self._store(replace(task, reason=reason))
        for robot, trip in trips(self._robots, self._tasks_of(), self.sites, now, tasks_wait=bool(waiting)):
            before = self._task(robot)
            if before is not None and before.trip == "park":
                orders += self._end(before, "cancelled", "its robot charges", now)
            elif before is not None:
                orders += self._queue(before, f"robot {robot!r} must charge")
            self._task_of[robot] = trip.id
            orders += [*self._store(trip), self._send(trip)]
        return orders

    def _tasks_of(self) -> dict[str, Task]:
        return {robot: self._tasks[name] for robot, name in self._task_of.items()}

    def _preempt(self, now: float, distance: Distance) -> list[Order]:
        """Give tasks that preempt, and have no robot, those of tasks of lower priorities that carry nothing."""
        waiting = [
            task for task in self._tasks.values() if task.preempts and not task.robot and self._may_begin(task, now)
        ]
        orders: list[Order] = []
        for task in sorted(waiting, key=lambda task: (-task.priority, task.created, task.id)):
            ways = {
                name: (other.priority, way, name)
                for name, other, place in self._preemptible(task)
                if math.isfinite(way := distance(place, task.target))
            }
            if ways:
                robot = min(ways, key=ways.__getitem__)
                other = self._tasks[self._task_of[robot]]
                orders += self._queue(other, f"task {task.id!r} of priority {task.priority} goes first")
                orders += self._move([(task, robot)], now)
        return orders

    def _preemptible(self, task: Task) -> list[tuple[str, Task, Place]]:
        """Return the robots that a task may take from others, with these and with their places."""
        found = []
        for name, robot in self._robots.items():
            other = self._task(name)
            if other is None or robot.place is None or robot.is_led or other.is_loaded:
                continue
            able = may_do(task, name, robot.labels, robot.place) and not must_charge(robot, None, self.sites)
            if other.priority < task.priority and able:
                found.append((name, other, robot.place))
        return found

    def _task(self, robot: str) -> Task | None:
        return self._tasks.get(self._task_of.get(robot, ""))

    def _move(self, moved: list[tuple[Task, str]], now: float) -> list[Order]:
        """Take tasks from their robots and give them to others; a robot without another task stops."""
        stopped: list[Order] = []
        for task, _ in moved:
            if task.robot:
                del self._task_of[task.robot]
                stopped.append(Cancel(task.robot, task.goal_id))
        given = {robot for _, robot in moved}
        orders: list[Order] = []
        for task, robot in moved:
            changes: dict[str, Any] = {"robot": robot, "attempt": task.attempt + bool(task.robot)}
            changes |= {"state": "assigned", "assigned": now} if robot else {"state": "queued", "assigned": None}
            changes["reason"] = "" if task.reason == NO_WAY else other_reason(task)
            changed = replace(task, **changes)
            orders += self._store(changed)
            if robot:
                self._task_of[robot] = task.id
                orders.append(self._send(changed))
        return orders + [order for order in stopped if isinstance(order, Cancel) and order.robot not in given]

    def _arrived(self, task: Task, now: float) -> list[Order]:
        task = replace(task, state="active", begun=now if task.begun is None else task.begun, reason="")
        if task.hold is not None:
            return self._store(replace(task, holding=now, confirmed=None))
        return self._go_on(task, now)

    def _go_on(self, task: Task, now: float) -> list[Order]:
        """Leave a place: for the next one, or for the end."""
        task = replace(task, leg=task.leg + 1, holding=None)
        if task.leg >= task.legs:
            return self._end(task, "done", "", now)
        return [*self._store(task), self._send(task)]

    def _gone(self, robot: str, now: float) -> list[Order]:
        del self._seen[robot]
        self._rests_until.pop(robot, None)
        task = self._task(robot)
        if task is None:
            return []
        reason = f"robot {robot!r} is not connected any more"
        if task.is_loaded:
            return self._end(task, "failed", _carries(reason), now)
        return [*self._queue(task, reason), Cancel(robot, task.goal_id)]

    def _failed(self, task: Task, reason: str, now: float) -> list[Order]:
        """Give a task back, unless it cannot be done by another robot or has failed too often."""
        failures = task.failures + 1
        task = replace(task, failures=failures)
        if task.is_loaded:
            return self._end(task, "failed", _carries(reason), now)
        if failures >= MOST_FAILURES:
            return self._end(task, "failed", f"{reason}; robots failed it {failures} times", now)
        return self._queue(task, reason)

    def _queue(self, task: Task, reason: str) -> list[Order]:
        """Take a task from its robot, and let it wait for another."""
        del self._task_of[task.robot]
        waits: dict[str, Any] = {"state": "queued", "robot": "", "assigned": None, "holding": None, "confirmed": None}
        return self._store(replace(task, attempt=task.attempt + 1, reason=reason, **waits))

    def _end(self, task: Task, state: TaskState, reason: str, now: float) -> list[Order]:
        self._tasks.pop(task.id)
        if task.robot:
            del self._task_of[task.robot]
        self._ended[task.id] = state
        ended = replace(task, state=state, reason=reason, ended=now, holding=None)
        again = following(task, now) if state in {"done", "failed"} else None
        if again is None or again.id in self._tasks or again.id in self._ended:
            return [StoreTask(ended)]
        # The next run is stored first: a dispatcher that is killed in between ends this one again.
        self._tasks[again.id] = again
        return [StoreTask(again), StoreTask(ended)]

    def _store(self, task: Task) -> list[Order]:
        self._tasks[task.id] = task
        return [StoreTask(task)]

    def _send(self, task: Task) -> Order:
        return Send(task.robot, task.goal_id, task.target, bool(task.floors))


def _carries(reason: str) -> str:
    return f"{reason}; it carries what it has picked: no other robot can go on"


def _unless(robot: str, busy: set[str]) -> str:
    return "" if robot in busy else robot


def _may_move(task: Task, free: set[str]) -> bool:
    return task.state == "assigned" and task.robot in free

"""Tasks of a user on a map or in a building: reads and stores their records, and obeys their dispatcher's orders."""

import asyncio
import dataclasses
import logging
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from functools import partial
from types import MappingProxyType

from msgspec.structs import replace

from engine.control.journeys.calls import TaskJourneys
from engine.control.tasks.areas import TaskArea
from engine.control.tasks.floor_trips import FloorTrips
from engine.control.tasks.robots import RobotGoal, TaskRobots
from ppaas.energy.sites import NO_SITES
from ppaas.errors import Conflict, NotFound, PPaaSError
from ppaas.tasks.assignment import Distance
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.floors import floor_of, on_floor
from ppaas.tasks.orders import Cancel, Order, RobotNow, Send, StoreTask
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Task
from storage.ports import TaskStore
from storage.records import MapTask

logger = logging.getLogger(__name__)


# -- retention of tasks that have ended --------------------------------------------------------------------------------

KEPT_FOR = 7 * 86400.0
"""Time for which a task is kept after its end [s]."""

OWN_KEPT_FOR = 3600.0
"""Time for which a trip to a charger or a parking spot is kept after its end [s], so that it displaces no tasks."""

MOST_ENDED = 1000
"""Number of ended tasks of a user on a map that are kept; the oldest are removed first."""


def obsolete(tasks: Sequence[Task], now: float, kept_for: float = KEPT_FOR) -> list[str]:
    """Return the ids of the tasks that are not kept any longer; those for whose end others wait are.

    The last trip of a robot to a charger is kept as a task of a user: it has what was learnt of its battery.

    Parameters
    ----------
    tasks : sequence of Task
        Tasks of a user on a map.
    now : float
        Time [s since the epoch].
    kept_for : float
        Time for which a task is kept after its end [s].
    """
    ended = sorted(((task.ended or 0.0, task.id) for task in tasks if not task.is_open), reverse=True)
    last = {task.robot: task.id for task in sorted(tasks, key=lambda task: task.created) if task.learnt is not None}
    own = {task.id: OWN_KEPT_FOR for task in tasks if task.trip and last.get(task.robot) != task.id}
    kept = {name for at, name in ended[:MOST_ENDED] if now - at <= min(kept_for, own.get(name, kept_for))}
    kept |= {before.task for task in tasks if task.is_open for before in task.after}
    return [name for _, name in ended if name not in kept]


# -- tasks of an area --------------------------------------------------------------------------------------------------

REREAD = 30.0
"""Time between two readings of records without a notice that they were changed [s]."""

DECIDE = 5.0
"""Time between two looks for a better assignment [s]; news of tasks and goals are a reason at once."""

LINGER = 60.0
"""Time for which robots are followed after the last task has ended [s]: a robot that comes back after a restart of the
master may drive for a task that was cancelled meanwhile."""

Measure = Callable[[Dispatcher, float], Awaitable[Distance]]
"""Returns the lengths of the ways that a decision needs."""

Changed = Callable[[str, str, Task], None]
"""Called with user, map and a task whose state was changed in the store."""

NO_FLOORS: Mapping[str, str] = MappingProxyType({})
"""Floors of robots on a map that is of no building."""


class TaskGroup:
    """Leads the tasks of a user on a map, or on all floors of a building.

    What is stored decides. After a failure, or a change by another process, the dispatcher is made again from the
    records, as it is after a restart.

    Parameters
    ----------
    area : TaskArea
        User and maps.
    store : TaskStore
    robots : TaskRobots
    journeys : TaskJourneys, optional
        Leads robots over floors; an area without floors needs none.
    changed : callable
        Called with each task whose state has changed.
    kept_for : float
        Time for which a task is kept after its end [s]; it may be changed.

    Attributes
    ----------
    sites : Sites
        Where robots charge and park.
    """

    def __init__(
        self,
        area: TaskArea,
        store: TaskStore,
        robots: TaskRobots,
        *,
        journeys: TaskJourneys | None = None,
        changed: Changed = lambda _user, _map, _task: None,
        kept_for: float = KEPT_FOR,
    ) -> None:
        self.area = area
        self.changed = True
        self.sites = NO_SITES
        self._store = store
        self._robots = robots
        self._report = partial(changed, area.user)
        self._trips = None if journeys is None else FloorTrips(journeys, area.user)
        self.kept_for = kept_for
        self._dispatcher: Dispatcher | None = None
        self._records: dict[str, MapTask] = {}
        self._floors = NO_FLOORS
        self._read_at = self._decided_at = self._busy_at = float("-inf")

    def is_open(self, now: float) -> bool:
        """Return whether there may be open tasks, goals of tasks that have ended, or robots that charge or park."""
        rests = bool(self.sites.chargers or self.sites.parking)
        return self.changed or self._dispatcher is None or rests or now - self._busy_at < LINGER

    def open_tasks(self) -> list[Task]:
        """Return the tasks that have not ended, as far as they were read."""
        return [] if self._dispatcher is None else [task for task in self._dispatcher.tasks.values() if task.is_open]

    async def step(
        self, labels: dict[str, dict[str, str]], now: float, measure: Measure, floors: Mapping[str, str] = NO_FLOORS
    ) -> None:
        """Look at the records and at the connected robots, and do what follows.

        Parameters
        ----------
        labels : dict
            Labels of the connected robots, by robot.
        now : float
            Time [s since the epoch].
        measure : callable
            Returns the lengths of ways.
        floors : mapping of str to str
            Floors that the robots are on.
        """
        self._floors = floors
        try:
            await self._step(labels, now, measure)
        except Conflict as error:  # somebody cancelled a task: go on from what is stored
            logger.info("tasks of user %s on maps %r are read again: %s", *self.area, error)
            self._forget()
        except BaseException:
            self._forget()
            raise

    async def _step(self, labels: dict[str, dict[str, str]], now: float, measure: Measure) -> None:
        news = self.changed or self._dispatcher is None
        dispatcher, orders = await self._read(now)
        dispatcher.sites = self.sites
        if news or dispatcher.tasks:
            self._busy_at = now
        await self._obey(orders)
        await self._see(dispatcher, labels, now)
        await self._send_waiting(dispatcher)
        self._note_buttons(dispatcher, labels)
        released = dispatcher.release(now)
        await self._obey(released)
        ended = [order for robot in {*labels, *dispatcher.away} for order in self._ended(dispatcher, robot, now)]
        await self._obey(ended)
        if news or released or ended or now - self._decided_at >= DECIDE:
            self._decided_at = now
            distance = await measure(dispatcher, now) if is_choice(dispatcher, now) else straight
            # For many robots it takes tens of milliseconds, in which the master would answer nobody.
            await self._obey(await asyncio.to_thread(dispatcher.decide, now, distance))

    def _forget(self) -> None:
        self._dispatcher, self.changed = None, True

    async def _read(self, now: float) -> tuple[Dispatcher, list[Order]]:
        """Return the dispatcher, which knows all stored tasks, and its orders about those that were cancelled."""
        known = self._dispatcher
        if known is not None and not self.changed and now - self._read_at < REREAD:
            return known, []
        self.changed = False
        stored = await asyncio.to_thread(self._stored, now)
        self._read_at = now
        self._report_ended(stored)
        self._recall_batteries([record.task for record in stored])
        self._records = {record.task.id: record for record in stored if record.task.is_open}
        dispatcher = self._dispatcher = known or Dispatcher([], now)
        dispatcher.keep_ends({record.task.id: record.task.state for record in stored if not record.task.is_open})
        for record in self._records.values():
            dispatcher.add(record.task, now)
            self._note_confirmation(dispatcher, record.task)
        orders = [
            order for name in dispatcher.tasks.keys() - self._records.keys() for order in dispatcher.withdraw(name)
        ]
        if any(record.task != dispatcher.tasks[name] for name, record in self._records.items()):
            raise Conflict("another process changed one of them")
        return dispatcher, orders

    def _recall_batteries(self, tasks: list[Task]) -> None:
        for task in sorted(tasks, key=lambda task: -task.created):
            if task.learnt is not None and task.robot:
                self._robots.recall(self.area.user, task.robot, task.learnt)

    def _note_confirmation(self, dispatcher: Dispatcher, task: Task) -> None:
        known = dispatcher.tasks[task.id]
        if task != known and task == replace(known, confirmed=task.confirmed):
            dispatcher.confirm(task)

    def _report_ended(self, stored: Iterable[MapTask]) -> None:
        """Report the tasks that another process has ended since the last reading: they were cancelled."""
        for record in stored:
            if record.task.id in self._records and not record.task.is_open:
                self._report(record.map, record.task)

    def _stored(self, now: float) -> list[MapTask]:
        """Return the stored tasks, with the floors of their maps; remove those that are not kept; may block."""
        found: list[MapTask] = []
        for floor, map_id in self.area.maps:
            stored = self._store.tasks(self.area.user, map_id)
            for name in obsolete([record.task for record in stored], now, self.kept_for):
                self._store.remove_task(self.area.user, map_id, name)
            found += [replace(record, task=replace(record.task, home=floor)) for record in stored]
        return found

    async def _see(self, dispatcher: Dispatcher, labels: dict[str, dict[str, str]], now: float) -> None:
        user = self.area.user
        charging = {
            task.robot for task in dispatcher.tasks.values() if task.trip == "charge" and task.holding is not None
        }
        renewed = [robot for robot in labels if self._robots.follow(user, robot)]
        seen: dict[str, RobotNow] = {
            robot: self._seen(dispatcher, robot, self._robots.now(user, robot, given, charging=robot in charging))
            for robot, given in labels.items()
            if self._robots.client(user, robot)
        }
        if renewed:
            await self._obey(dispatcher.see({name: now_ for name, now_ in seen.items() if name not in renewed}, now))
        silent = {task.robot for task in dispatcher.tasks.values() if task.robot} - seen.keys()
        riding = set() if self._trips is None else set(filter(self._trips.is_riding, silent))
        await self._obey(dispatcher.see(seen, now, self._lost(dispatcher), riding))

    def _seen(self, dispatcher: Dispatcher, robot: str, now: RobotNow) -> RobotNow:
        """Return a robot with the floor that it is on, and with the goals of its journeys, also while these wait.

        One that must leave a lift first has no place yet.
        """
        if self._trips is None or not self.area.has_floors:
            return now
        task = next((task for task in dispatcher.tasks.values() if task.robot == robot), None)
        is_leaving = self._trips.is_leaving(robot, "" if task is None else task.goal_id)
        place = None if is_leaving or now.place is None else on_floor(now.place, self._floors.get(robot, ""))
        return dataclasses.replace(now, place=place, goals=now.goals | self._trips.led(robot))

    def _note_buttons(self, dispatcher: Dispatcher, robots: Iterable[str]) -> None:
        """Confirm the tasks that hold robots whose buttons were pressed."""
        pressed = {robot for robot in robots if self._robots.is_confirmed(self.area.user, robot)}
        for task in tuple(dispatcher.tasks.values()):
            if task.robot in pressed and task.needs_confirmation:
                dispatcher.confirm(replace(task, confirmed=task.leg))

    def _lost(self, dispatcher: Dispatcher) -> dict[str, float]:
        """Return when the robots with a task were lost that are not connected [s since the epoch], as far as known."""
        lost = {robot: self._robots.lost_at(self.area.user, robot) for robot in dispatcher.away}
        return {robot: at for robot, at in lost.items() if at is not None}

    def _ended(self, dispatcher: Dispatcher, robot: str, now: float) -> list[Order]:
        for goal in (*self._robots.goals(self.area.user, robot), *self._on_floors(robot)):
            if goal.state == "pending" or goal.state == "active":  # noqa: PLR1714 - mypy narrows no sets
                continue
            orders = dispatcher.goal_ended(robot, goal.id, goal.state, goal.text, now)
            if orders:
                return orders
        return []

    def _on_floors(self, robot: str) -> Sequence[RobotGoal]:
        """Return the goals on floors of a robot, but for one after which it docks."""
        if self._trips is None:
            return []
        order = self._trips.docking.get(robot)
        goals = self._trips.goals(robot)
        if order is not None and any((goal.id, goal.state) == (order.goal_id, "succeeded") for goal in goals):
            self._robots.send(self.area.user, robot, order)
            return [goal for goal in goals if goal.id != order.goal_id]
        return goals

    async def _obey(self, orders: list[Order]) -> None:
        for order in orders:
            match order:
                case StoreTask():
                    await self._put(order)
                case Send():
                    await self._send(order)
                case Cancel():
                    await self._cancel(order)

    async def _put(self, order: StoreTask) -> None:
        before = self._records.get(order.task.id)
        record = MapTask(self.area.user, self.area.map_on(order.task.home), order.task)
        if before is None:
            await asyncio.to_thread(self._put_new, record)
            self._records[order.task.id] = record
            return
        await asyncio.to_thread(lambda: self._store.put_task(_as_stored(record), instead_of=_as_stored(before)))
        self._records[order.task.id] = record
        if order.task.state != before.task.state:
            self._report(record.map, order.task)
        if not order.task.is_open:
            del self._records[order.task.id]

    def _put_new(self, record: MapTask) -> None:
        """Store the next run of a task, unless it was stored before its task ended again."""
        try:
            self._store.task(*record.key)
        except NotFound:
            self._store.put_task(_as_stored(record))

    async def _send(self, order: Send) -> None:
        floor = floor_of(order.place)
        if self._robots.client(self.area.user, order.robot) is None:
            return  # it is sent once the robot is there
        try:
            if self._trips is not None and not await self._trips.make_way(order):
                return  # it is sent once the robot is out of the lift
            if self._trips is not None and (order.over_floors or self._floors.get(order.robot, floor) != floor):
                if self._robots.leaves_dock(self.area.user, order.robot, order.goal_id):
                    self._trips.waiting[order.robot] = order
                else:
                    await self._trips.send(order)
            else:
                self._robots.send(self.area.user, order.robot, order)
        except PPaaSError as error:
            raise Conflict(f"goal {order.goal_id!r} of robot {order.robot!r} is sent again: {error}") from error

    async def _send_waiting(self, dispatcher: Dispatcher) -> None:
        """Send the robots that have left a lift or a dock meanwhile to the goals that waited for that."""
        wanted = {task.goal_id for task in dispatcher.tasks.values()}
        for order in [] if self._trips is None else tuple(self._trips.waiting.values()):
            if order.goal_id in wanted:
                await self._send(order)

    async def _cancel(self, order: Cancel) -> None:
        if self._trips is None or not await self._trips.cancel(order.robot, order.goal_id):
            self._robots.cancel(self.area.user, order.robot, order.goal_id)


def _as_stored(record: MapTask) -> MapTask:
    """Return a record without the floor of its map, which follows from the building."""
    return replace(record, task=replace(record.task, home=""))


def is_choice(dispatcher: Dispatcher, now: float) -> bool:
    """Return whether lengths of ways matter: more than one assignment is possible, or a task leads over floors."""
    free, tasks = dispatcher.candidates(now), dispatcher.undecided(now)
    return bool(free and tasks) and (len(free) > 1 or len(tasks) > 1 or any(task.floors for task in tasks))

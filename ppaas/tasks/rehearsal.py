"""Rehearsal of tasks: the dispatcher itself leads simulated robots, which drive ways of known lengths at one speed."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from dataclasses import replace as replace_battery

from msgspec.structs import replace

from ppaas.energy.battery import Battery
from ppaas.energy.sites import NO_SITES, Sites
from ppaas.tasks.assignment import Distance
from ppaas.tasks.dispatcher import REST, Dispatcher
from ppaas.tasks.floors import floor_of, on_floor
from ppaas.tasks.options import PlaceHold
from ppaas.tasks.orders import Cancel, Order, Outcome, RobotNow, Send, StoreTask
from ppaas.tasks.reach import CONFIRMED_AFTER, SPEED
from ppaas.tasks.records import Place, Task

LOOK = 30.0
"""Time between two looks at batteries [s]."""

MOST_STEPS = 100_000
"""Number of moments at which something happens, after which a rehearsal ends."""


Ways = tuple[tuple[Place, float], ...]
"""Known places and the lengths of the ways to them [m]."""

MOST_WAYS = 3
"""Number of known places whose ways are kept of a robot that was sent elsewhere on its way."""


@dataclass(slots=True)
class _Driver:
    """A simulated robot, at rest or on its way from ``start`` to ``target``."""

    start: Place
    ways: Ways
    labels: Mapping[str, str]
    battery: Battery | None = None
    known_at: float = 0.0
    goal: str = ""
    target: Place = (0.0, 0.0, 0.0)
    left_at: float = 0.0
    length: float = 0.0
    arrives: float = math.inf
    outcome: Outcome = "succeeded"

    def use(self, now: float, *, charging: bool) -> None:
        """Spend or gain the charge of the time since the last call; an empty battery stops the robot for good."""
        seconds, self.known_at = now - self.known_at, now
        if self.battery is None or seconds <= 0.0:
            return
        metres = self.length * seconds / (self.arrives - self.left_at) if self.is_driving and self.length else 0.0
        left = self.battery.charge + self.battery.gain * seconds if charging else self.battery.after(metres, seconds)
        self.battery = replace_battery(self.battery, charge=min(1.0, max(0.0, left)))

    def share(self, now: float) -> float:
        """Return which part of its way it has driven."""
        whole = self.arrives - self.left_at
        return 1.0 if whole <= 0.0 else min(1.0, (now - self.left_at) / whole)

    def place(self, now: float) -> Place:
        """Return where it is, as if its way were straight."""
        if not self.is_driving:
            return self.start
        share, (x, y, _), (to_x, to_y, yaw) = self.share(now), self.start, self.target
        if floor_of(self.start) != floor_of(self.target):
            return self.start if share < 0.5 else self.target
        return on_floor((x + share * (to_x - x), y + share * (to_y - y), yaw), floor_of(self.start))

    def ways_now(self, now: float) -> Ways:
        """Return the ways that it knows: on, or back."""
        if not self.is_driving:
            return self.ways
        driven = self.share(now) * self.length
        back = tuple((place, way + driven) for place, way in self.ways)
        return ((self.target, self.length - driven), *back)[:MOST_WAYS]

    @property
    def is_driving(self) -> bool:
        """Return whether it is on a way that leads somewhere."""
        return bool(self.goal) and self.outcome == "succeeded"

    def drive(self, goal: str, target: Place, length: float, now: float) -> None:
        """Leave for a place, or find that no way leads there."""
        self.start, self.ways = self.place(now), self.ways_now(now)
        self.goal, self.target, self.left_at, self.length = goal, target, now, length
        self.outcome = "succeeded" if math.isfinite(length) else "aborted"
        self.arrives = now + (length / SPEED if math.isfinite(length) else 0.0)

    def stop(self, now: float) -> None:
        """Stop where it is."""
        self.start, self.ways = self.place(now), self.ways_now(now)
        self.goal, self.arrives = "", math.inf

    def arrive(self) -> None:
        """Be where it was sent, unless no way leads there."""
        if self.outcome == "succeeded":
            self.start, self.ways = self.target, ((self.target, 0.0),)
        self.goal, self.arrives = "", math.inf


class Rehearsal:
    """Leads simulated robots through tasks, from event to event.

    Parameters
    ----------
    tasks : iterable of Task
        Tasks as they are stored.
    robots : mapping of str to RobotNow
        Robots that take part; others than those that know their place and that nobody else leads stay away.
    distance : callable
        Returns the length of the way between two places [m].
    now : float
        Time at which it begins [s since the epoch].
    confirmed_after : float
        Time after which a hold is confirmed [s].
    sites : Sites
        Where robots charge and park.
    period : float
        Least time between two decisions [s].

    Attributes
    ----------
    now : float
        Simulated time [s since the epoch].
    tasks : dict of str to Task
        Records of all tasks as they are at that time, by id; next runs of tasks that repeat among them.
    """

    def __init__(
        self,
        tasks: Iterable[Task],
        robots: Mapping[str, RobotNow],
        distance: Distance,
        now: float,
        *,
        confirmed_after: float = CONFIRMED_AFTER,
        sites: Sites = NO_SITES,
        period: float = 0.0,
    ) -> None:
        self.now = now
        self.tasks = {task.id: task for task in tasks}
        self._confirmed_after, self._period = confirmed_after, period
        self._decided_at, self._has_news = -math.inf, True
        self._distance = distance
        self._dispatcher = Dispatcher(self.tasks.values(), now)
        self._dispatcher.sites = sites
        self._drivers = {
            name: _Driver(robot.place, ((robot.place, 0.0),), robot.labels, robot.battery, now)
            for name, robot in robots.items()
            if robot.place is not None and not robot.is_led
        }
        self._rests: list[float] = []
        self._ways: dict[Place, Ways] = {}

    @property
    def stranded(self) -> list[str]:
        """Robots whose batteries are empty."""
        return [name for name, driver in self._drivers.items() if driver.battery and driver.battery.charge <= 0.0]

    @property
    def open_tasks(self) -> list[Task]:
        """Tasks that have not ended."""
        return list(self._dispatcher.tasks.values())

    @property
    def batteries(self) -> dict[str, Battery | None]:
        """Batteries of the robots."""
        return {name: driver.battery for name, driver in self._drivers.items()}

    def add(self, task: Task) -> None:
        """Add a task now."""
        self.tasks[task.id], self._has_news = task, True
        self._dispatcher.add(task, self.now)

    def run(self, until: float, is_over: Callable[[], bool] = lambda: False) -> None:
        """Go on until a time [s since the epoch], until nothing more happens, or until ``is_over``."""
        for _ in range(MOST_STEPS):
            self._step()
            following = self._next()
            if is_over() or math.isinf(following):
                return
            if following > until:
                self.now = max(self.now, until)
                return
            self.now = following

    def _step(self) -> None:
        now, dispatcher = self.now, self._dispatcher
        charging = {
            task.robot for task in dispatcher.tasks.values() if task.trip == "charge" and task.holding is not None
        }
        for name, driver in self._drivers.items():
            driver.use(now, charging=name in charging)
        places = {name: driver.place(now) for name, driver in self._drivers.items()}
        self._ways = {places[name]: driver.ways_now(now) for name, driver in self._drivers.items()}
        self._obey(dispatcher.see({name: self._seen(name, places[name]) for name in places}, now))
        for name, driver in self._drivers.items():
            if driver.goal and driver.arrives <= now:
                self._has_news = True
                self._obey(dispatcher.goal_ended(name, *self._ended(driver), now))
        for task in tuple(dispatcher.tasks.values()):
            if task.needs_confirmation and now >= (task.holding or 0.0) + self._confirmed_after:
                dispatcher.confirm(replace(task, confirmed=task.leg))
        self._obey(dispatcher.release(now))
        if now - self._decided_at >= self._period:
            self._decided_at, self._has_news = now, False
            self._obey(dispatcher.decide(now, self._way))

    def _seen(self, name: str, place: Place) -> RobotNow:
        driver = self._drivers[name]
        return RobotNow(place, driver.labels, frozenset({driver.goal} if driver.goal else ()), driver.battery)

    def _ended(self, driver: _Driver) -> tuple[str, Outcome, str]:
        goal, outcome = driver.goal, driver.outcome
        driver.arrive()
        if outcome == "succeeded":
            return goal, outcome, ""
        self._rests.append(self.now + REST)
        return goal, outcome, "no way leads there"

    def _way(self, start: Place, goal: Place) -> float:
        """Return the length of a way; a robot under way goes on, or back, before it takes another one."""
        ways = self._ways.get(start, ((start, 0.0),))
        return min(way + (0.0 if place == goal else self._distance(place, goal)) for place, way in ways)

    def _obey(self, orders: list[Order]) -> None:
        for order in orders:
            match order:
                case StoreTask():
                    self.tasks[order.task.id] = order.task
                case Send():
                    self._send(order)
                case Cancel():
                    driver = self._drivers.get(order.robot)
                    if driver is not None and driver.goal == order.goal_id:
                        driver.stop(self.now)

    def _send(self, order: Send) -> None:
        driver = self._drivers.get(order.robot)
        if driver is None or driver.goal == order.goal_id:
            return
        ways = driver.ways_now(self.now)
        length = min(way + (0.0 if place == order.place else self._distance(place, order.place)) for place, way in ways)
        driver.drive(order.goal_id, order.place, length, self.now)

    def _next(self) -> float:
        """Return the time at which something happens next; infinite if nothing does."""
        arrives = min((driver.arrives for driver in self._drivers.values()), default=math.inf)
        if arrives <= self.now:
            return self.now
        times = [arrives, *self._rests]
        if self._has_news:
            times.append(self._decided_at + self._period)
        if self._dispatcher.sites.chargers and (self._dispatcher.tasks or math.isfinite(arrives)):
            times.append(self.now + LOOK)
        for task in self._dispatcher.tasks.values():
            if task.holding is not None and task.hold is not None:
                times.append(task.holding + self._longest(task.hold))
            elif not task.robot:
                times += [task.may_start, math.nextafter(task.deadline or 0.0, math.inf)]
        return min((at for at in times if at > self.now), default=math.inf)

    def _longest(self, hold: PlaceHold) -> float:
        limit = math.inf if hold.seconds is None else hold.seconds
        if hold.charge is not None:
            limit = min(limit, LOOK)
        return min(limit, self._confirmed_after) if hold.is_confirmed else limit

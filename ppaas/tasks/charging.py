"""Charging and parking: which robots go to which chargers and parking spots, and when chargers are left again.

Trips to chargers and spots are tasks with a ``trip``: they are stored, and go on after a restart.
"""

from collections.abc import Iterable, Mapping

from ppaas.energy.sites import Sites
from ppaas.tasks.assignment import may_do
from ppaas.tasks.floors import bare, floor_of
from ppaas.tasks.options import PlaceHold
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import DETOUR, RESERVE, SPEED, lasts, least_cost, straight, way_home
from ppaas.tasks.records import MOST_PRIORITY, Place, Task, Trip

LOW = 0.25
"""Charge below which a robot without a load goes to a charger, whatever there is to do."""

OPPORTUNE = 0.7
"""Charge below which a robot without anything to do goes to a charger that is free."""

ALMOST_FULL = 0.85
"""Charge below which a robot that can do none of the tasks that wait goes to a charger that is free, and from which a
robot leaves its charger if others need it."""

PATIENCE = 300.0
"""Time for which a task has waited before a robot leaves its charger for it [s]."""

ENOUGH = 0.5
"""Charge from which a robot leaves its charger for a task that waits, if no other robot needs the charger."""

FULL = 0.95
"""Charge from which a robot leaves its charger."""

MARGIN = 0.03
"""Charge above the reserve, with the way to a charger, from which a robot must go there."""

NEAR = 1.0
"""Distance from a spot from which a robot is not there [m]."""

_TOO_FAR = "no battery lasts for it: it takes"


def must_charge(robot: RobotNow, task: Task | None, sites: Sites) -> bool:
    """Return whether a robot must go to a charger now; one with a load goes on: it had the charge for its task."""
    battery, place = robot.battery, robot.place
    if battery is None or place is None or robot.is_led or not sites.chargers:
        return False
    if task is not None and (task.trip == "charge" or task.is_loaded):
        return False
    rests = task is None or task.trip == "park"
    metres = way_home(place, sites)
    if task is not None and task.state == "active" and task.holding is None:
        metres = DETOUR * straight(place, task.target) + way_home(task.target, sites)
    return battery.after(metres, metres / SPEED) < RESERVE + MARGIN or (rests and battery.charge < LOW)


def trips(
    robots: Mapping[str, RobotNow], task_of: Mapping[str, Task], sites: Sites, now: float, *, tasks_wait: bool
) -> list[tuple[str, Task]]:
    """Return the trips to chargers and parking spots that robots begin now, by robot.

    Parameters
    ----------
    robots : mapping of str to RobotNow
        Connected robots; those without a task can do none that waits.
    task_of : mapping of str to Task
        Their tasks.
    sites : Sites
    now : float
        Time [s since the epoch].
    tasks_wait : bool
        Whether tasks wait for robots.
    """
    charge = {name: _charge(robot) for name, robot in robots.items()}
    needy = {name for name, robot in robots.items() if must_charge(robot, task_of.get(name), sites)}
    idle = [name for name, robot in robots.items() if name not in needy and _is_idle(robot, task_of.get(name))]
    limit = ALMOST_FULL if tasks_wait else OPPORTUNE
    wish = sorted(needy, key=lambda name: (charge[name], name))
    wish += sorted((name for name in idle if charge[name] < limit), key=lambda name: (charge[name], name))
    taken = [task.target for task in task_of.values() if task.trip == "charge"]
    charging = _matched(wish, robots, [place for place in sites.chargers.values() if place not in taken])
    gone = {name for name, _ in charging}
    stay = [name for name in idle if name not in gone and name not in task_of]
    away = [name for name in stay if not _is_at(robots[name], sites.parking.values())]
    spots = [place for place in sites.parking.values() if not _is_taken(place, robots, task_of)]
    parking = _matched(sorted(away), robots, spots)
    given: list[tuple[Trip, list[tuple[str, Place]]]] = [("charge", charging), ("park", parking)]
    return [
        (name, _trip(trip, (robots[name].place or place, place), name, now, number))
        for trip, found in given
        for number, (name, place) in enumerate(found)
    ]


def leavers(
    robots: Mapping[str, RobotNow], task_of: Mapping[str, Task], sites: Sites, waiting: Iterable[Task], now: float
) -> list[str]:
    """Return the robots that leave their chargers early: others need these, or tasks wait; the fullest first.

    To leave early costs trips: only robots that are almost full leave for others, and then none leaves for a task.
    """
    holds = [name for name, task in task_of.items() if task.trip == "charge" and task.holding is not None]
    charge = {name: _charge(robots[name]) for name in holds if name in robots}
    enough = sorted((name for name in charge if charge[name] >= ENOUGH), key=lambda name: (-charge[name], name))
    most = [name for name in enough if charge[name] >= ALMOST_FULL]
    needy = sum(must_charge(robot, task_of.get(name), sites) for name, robot in robots.items())
    free = len(sites.chargers) - sum(task.trip == "charge" for task in task_of.values())
    leave = most[: max(0, needy - free)]
    if needy > free:
        return leave
    idle = sum(_is_idle(robot, task_of.get(name)) for name, robot in robots.items())
    left = [task for task in waiting if now - task.may_start >= PATIENCE]
    spare = len(left) - idle
    for name in enough:
        task = next((task for task in left if _can_do(task, name, robots[name], sites)), None)
        if task is not None and spare > 0:
            left.remove(task)
            leave.append(name)
            spare -= 1
    return leave


def _can_do(task: Task, name: str, robot: RobotNow, sites: Sites) -> bool:
    assert robot.place is not None, "it is at its charger"
    way = DETOUR * straight(robot.place, task.target)
    return may_do(task, name, robot.labels, robot.place) and lasts(task, way, robot.battery, sites)


def reach_reason(task: Task, robots: Mapping[str, RobotNow], sites: Sites) -> str:
    """Return the reason of a task that waits, which says so if no battery of a robot for it lasts."""
    able = [
        robot.battery
        for name, robot in robots.items()
        if robot.battery is not None and may_do(task, name, robot.labels, robot.place)
    ]
    if not able or not sites.chargers:
        return task.reason
    least = min(least_cost(task, battery, sites) for battery in able)
    if least > 1.0 - RESERVE:
        return f"{_TOO_FAR} {100.0 * least:.0f} % of one, with the way to a charger"
    return other_reason(task)


def other_reason(task: Task) -> str:
    """Return the reason of a task, unless that is that no battery lasts for it."""
    return "" if task.reason.startswith(_TOO_FAR) else task.reason


def is_charged(task: Task, robot: RobotNow | None) -> bool:
    """Return whether the robot of a task has the charge for which it holds."""
    hold = task.hold
    if hold is None or hold.charge is None or robot is None or robot.battery is None:
        return False
    return robot.battery.charge >= hold.charge


def _is_idle(robot: RobotNow, task: Task | None) -> bool:
    return robot.place is not None and not robot.is_led and (task is None or task.trip == "park")


def _charge(robot: RobotNow) -> float:
    return 1.0 if robot.battery is None else robot.battery.charge


def _is_at(robot: RobotNow, places: Iterable[Place]) -> bool:
    return robot.place is not None and any(straight(robot.place, place) <= NEAR for place in places)


def _is_taken(place: Place, robots: Mapping[str, RobotNow], task_of: Mapping[str, Task]) -> bool:
    planned = any(task.trip == "park" and task.target == place for task in task_of.values())
    return planned or any(_is_at(robot, [place]) for robot in robots.values())


def _matched(names: list[str], robots: Mapping[str, RobotNow], places: list[Place]) -> list[tuple[str, Place]]:
    """Return the nearest place of each robot that is left by those before it."""
    found, left = [], list(places)
    for name in names:
        place = robots[name].place
        if left and place is not None:
            nearest = min(left, key=lambda spot: straight(place, spot))
            left.remove(nearest)
            found.append((name, nearest))
    return found


def _trip(trip: Trip, way: tuple[Place, Place], robot: str, now: float, number: int) -> Task:
    """Return a trip from where the robot is to a place, also on another floor."""
    charge, here, floor = trip == "charge", floor_of(way[0]), floor_of(way[1])
    return Task(
        id=f"{int(now * 1000.0):012x}-{trip}{number}",
        kind="go_to",
        trip=trip,
        places=(bare(way[1]),),
        floors=() if floor == here else (floor,),
        home=floor,
        priority=MOST_PRIORITY if charge else -MOST_PRIORITY,
        holds=(PlaceHold(charge=FULL),) if charge else (),
        named_robot=robot,
        created=now,
        state="assigned",
        robot=robot,
        assigned=now,
    )

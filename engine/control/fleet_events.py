"""Events of a cloud that others are notified of: goals that end, tasks that change, robots that are lost, faults.

They are reported where they happen, in the process of the master, to all that listen there.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from engine.control.buildings.building_runner import BuildingAlert
from engine.control.views import GoalState
from engine.master.places import PlaceRequest, robot_of
from ppaas.buildings.building import Building
from ppaas.buildings.doors.states import DoorAlert
from ppaas.buildings.faults import FaultChange
from ppaas.buildings.lifts.states import LiftAlert
from ppaas.clock import Clock, epoch
from ppaas.listener_faults import ListenerFaults
from ppaas.tasks.records import Task, TaskState
from storage.disk_space import SpaceState

logger = logging.getLogger(__name__)

LONGEST_TEXT = 400
"""Length of a reason in an event [characters]."""

GOAL_EVENTS: Mapping[GoalState, str] = {
    "succeeded": "goal.reached",
    "aborted": "goal.failed",
    "rejected": "goal.failed",
    "lost": "goal.failed",
    "canceled": "goal.canceled",
}
"""Type of the event of a goal that has ended, by its state."""

TASK_EVENTS: Mapping[TaskState, str] = {
    "queued": "task.queued",
    "assigned": "task.assigned",
    "active": "task.active",
    "done": "task.done",
    "failed": "task.failed",
    "cancelled": "task.cancelled",
}
"""Type of the event of a task that has changed, by its new state."""

BUILDING_EVENTS = ("lift.fault", "lift.ok", "lift.alert", "door.fault", "door.ok", "door.alert")
"""Types of the events of a lift or a door: it has a fault, serves again, or people must look at it."""

ROBOT_CONNECTED, ROBOT_LOST = "robot.connected", "robot.lost"
CONTAINER_LOST, MACHINE_LOST = "alert.container_lost", "alert.machine_lost"
DISK_EVENTS: Mapping[SpaceState, str] = {"ok": "alert.disk_ok", "low": "alert.disk_low", "full": "alert.disk_full"}
"""Type of the event of a change of the free space, by the new state."""

ALERT = "alert."
"""Beginning of the types of events of the cloud itself, which concern administrators."""

EVENT_TYPES = (
    *dict.fromkeys(GOAL_EVENTS.values()),
    *TASK_EVENTS.values(),
    *BUILDING_EVENTS,
    ROBOT_CONNECTED,
    ROBOT_LOST,
    CONTAINER_LOST,
    MACHINE_LOST,
    *DISK_EVENTS.values(),
)
"""All types of events."""

LOST_AFTER = 10.0
"""Time without a connection after which a robot is reported as lost [s]; one that is back sooner is not reported."""


class FleetEvent(msgspec.Struct, frozen=True, kw_only=True):
    """An event.

    Parameters
    ----------
    type : str
        One of ``EVENT_TYPES``.
    user : str
        User of the robot or the task; empty for an event of the cloud itself.
    robot, map : str
        Ids; empty if it concerns none.
    time : float
        [s since the epoch]
    data : dict
        What else is known, as JSON has it.
    """

    type: str
    user: str = ""
    robot: str = ""
    map: str = ""
    time: float = msgspec.field(default_factory=epoch)
    data: dict[str, Any] = {}


class FleetEvents:
    """Passes events on to those who asked for them."""

    def __init__(self) -> None:
        self._listeners: list[Callable[[FleetEvent], None]] = []
        self._faults = ListenerFaults(logger)

    def listen(self, hear: Callable[[FleetEvent], None]) -> None:
        """Pass events on to a function, too; it must not block."""
        self._listeners.append(hear)

    def leave(self, hear: Callable[[FleetEvent], None]) -> None:
        """Stop passing events on to a function."""
        if hear in self._listeners:
            self._listeners.remove(hear)

    def report(self, event: FleetEvent) -> None:
        """Pass an event on to all listeners."""
        for hear in tuple(self._listeners):
            self._faults.call(f"a listener to {event.type}", hear, event)

    # -- events --------------------------------------------------------------------------------------------------------

    def goal_ended(self, key: str, request: PlaceRequest | None, goal: Mapping[str, Any]) -> None:
        """Report the end of a goal of the robot of a place, with its id, state and text, and what else is known."""
        kind = GOAL_EVENTS.get(goal["state"])
        if kind is not None:
            self.report(_of_robot(kind, key, request, goal={**goal, "text": goal["text"][:LONGEST_TEXT]}))

    def task_changed(self, user: str, map_id: str, task: Task) -> None:
        """Report the new state of a task."""
        names = ("id", "kind", "state", "priority", "failures", "created", "assigned", "begun", "ended")
        known = {name: getattr(task, name) for name in names}
        known |= {"visited": task.leg, "reason": task.reason[:LONGEST_TEXT], "labels": task.labels}
        self.report(
            FleetEvent(type=TASK_EVENTS[task.state], user=user, robot=task.robot, map=map_id, data={"task": known})
        )

    def building_alerted(self, key: tuple[str, str], building: Building, alert: BuildingAlert) -> None:
        """Report what is wrong with a lift or a door to the owner of the building, and to the user of the robot."""
        owner, name = key
        user, _, robot = ("", "", "") if isinstance(alert, FaultChange) else alert.robot.partition("/")
        kind, floor, part, cause, text = _told(alert)
        map_id = building.floor(floor).map if floor else ""
        data = {"building": name, "owner": owner, kind: part, "floor": floor, "reason": text[:LONGEST_TEXT]}
        for hears in dict.fromkeys((owner, user or owner)):
            named = robot if hears == user else ""
            self.report(FleetEvent(type=f"{kind}.{cause}", user=hears, robot=named, map=map_id, data=data))

    def container_lost(self, container: str, request: PlaceRequest, reason: str) -> None:
        """Report a container that was lost and is replaced, to administrators."""
        robot = "" if request.robot is None else request.robot.id
        data = {"container": container, "user": request.user, "reason": reason[:LONGEST_TEXT]}
        self.report(FleetEvent(type=CONTAINER_LOST, robot=robot, map=request.map.id, data=data))

    def machine_lost(self, machine: str) -> None:
        """Report a machine that has left, to administrators."""
        self.report(FleetEvent(type=MACHINE_LOST, data={"machine": machine}))

    def disk_changed(self, state: SpaceState, reason: str) -> None:
        """Report that space runs out or is back, to administrators."""
        self.report(FleetEvent(type=DISK_EVENTS[state], data={"reason": reason}))


def _told(alert: BuildingAlert) -> tuple[str, str, str, str, str]:
    """Return what an alert is of, floor and name of it, its kind, and the reason."""
    match alert:
        case LiftAlert(lift, _, text):
            return "lift", "", lift, "alert", text
        case DoorAlert(floor, door, _, text):
            return "door", floor, door, "alert", text
        case FaultChange(part, text):
            return part.kind, part.floor, part.name, "fault" if text else "ok", text


def _of_robot(kind: str, key: str, request: PlaceRequest | None, **data: Any) -> FleetEvent:
    user, robot = robot_of(key)
    map_id = "" if request is None else request.map.id
    return FleetEvent(type=kind, user=user, robot=robot, map=map_id, data=data)


class LostRobots:
    """Reports robots that are lost, and those that connect.

    Parameters
    ----------
    events : FleetEvents
    request_of : callable
        Returns the request of an open place.
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(
        self, events: FleetEvents, request_of: Callable[[str], PlaceRequest | None], clock: Clock = epoch
    ) -> None:
        self._events = events
        self._request_of = request_of
        self._clock = clock
        self._away: dict[str, asyncio.TimerHandle] = {}

    def changed(self, key: str, here: bool) -> None:
        """Note that the robot of a place is connected, or not any more."""
        timer = self._away.pop(key, None)
        if timer is not None:
            timer.cancel()
        request = self._request_of(key)
        if not here:
            lost = _of_robot(ROBOT_LOST, key, request, disconnected_since=self._clock())
            self._away[key] = asyncio.get_running_loop().call_later(LOST_AFTER, self._lost, key, lost)
        elif timer is None:
            self._events.report(_of_robot(ROBOT_CONNECTED, key, request))

    def close(self) -> None:
        """Report nothing more."""
        for timer in self._away.values():
            timer.cancel()
        self._away.clear()

    def _lost(self, key: str, event: FleetEvent) -> None:
        del self._away[key]
        self._events.report(msgspec.structs.replace(event, time=self._clock()))

"""Events of a cloud, reported where they happen: goals, tasks, robots that come and go, containers and machines."""

import asyncio
from typing import Any

import pytest

from engine.control import fleet_events
from engine.control.fleet_events import EVENT_TYPES, FleetEvent, FleetEvents, LostRobots
from engine.control.other_goals import OtherGoals
from engine.links.presence import RobotPresence
from engine.master.places import robot_key, robot_of
from ppaas.buildings.building import Building, Floor
from ppaas.buildings.doors.states import DoorAlert
from ppaas.buildings.faults import FaultChange, PartName
from ppaas.buildings.lifts.states import LiftAlert
from ppaas.clock import ManualClock
from ppaas.tasks.records import Task
from tests.support.endpoints.still_place import StillRobot
from tests.support.engine.specs import robot_request
from tests.support.waiting import until

KEY = robot_key("ann", "tb1")


class Heard(FleetEvents):
    """Events, and those that a listener has heard."""

    def __init__(self) -> None:
        super().__init__()
        self.all: list[FleetEvent] = []
        self.listen(self.all.append)

    @property
    def types(self) -> list[str]:
        return [event.type for event in self.all]


class Robots:
    """Open places of robots, whose presence is reported."""

    def __init__(self, events: FleetEvents) -> None:
        self.places: dict[str, StillRobot] = {}
        self.presence = RobotPresence(self.places.get, ManualClock(1000.0))
        self.lost = LostRobots(events, self.request_of, ManualClock(1000.0))
        self.presence.listen(self.lost.changed)

    def place(self, key: str) -> StillRobot | None:
        return self.places.get(key)

    def request_of(self, key: str) -> Any:
        return robot_request(robot_of(key)[1]) if key in self.places else None

    def open(self, key: str = KEY) -> StillRobot:
        self.places[key] = StillRobot()
        self.places[key].key = key
        return self.places[key]


@pytest.fixture
def events() -> Heard:
    return Heard()


@pytest.fixture
def robots(events: Heard, monkeypatch: pytest.MonkeyPatch) -> Robots:
    monkeypatch.setattr(fleet_events, "LOST_AFTER", 0.05)
    return Robots(events)


async def test_a_robot_that_connects_and_one_that_is_lost_are_reported(events: Heard, robots: Robots) -> None:
    robots.open()
    robots.presence.came(KEY)
    robots.presence.left(KEY)
    assert events.types == ["robot.connected"]
    await until(lambda: len(events.all) == 2)
    lost = events.all[1]
    assert (lost.type, lost.user, lost.robot, lost.map) == ("robot.lost", "ann", "tb1", "house")
    assert lost.data == {"disconnected_since": 1000.0}
    robots.presence.came(KEY)
    assert events.types[2:] == ["robot.connected"]


async def test_a_robot_that_is_back_soon_is_not_reported(events: Heard, robots: Robots) -> None:
    robots.open()
    robots.presence.came(KEY)
    for _ in range(3):
        robots.presence.left(KEY)
        robots.presence.came(KEY)
    await asyncio.sleep(0.1)
    assert events.types == ["robot.connected"]


async def test_a_robot_that_was_there_before_the_master_is_not_reported(events: Heard, robots: Robots) -> None:
    robots.open()
    robots.presence.expect(KEY)
    robots.presence.came(KEY)
    assert events.types == []
    robots.presence.left(KEY)
    robots.presence.expect(KEY)
    robots.presence.give_up(KEY)
    await until(lambda: events.types == ["robot.lost"])


async def test_nothing_is_reported_after_the_end(events: Heard, robots: Robots) -> None:
    robots.presence.came(KEY)
    robots.presence.left(KEY)
    robots.lost.close()
    await asyncio.sleep(0.1)
    assert events.types == ["robot.connected"]


@pytest.mark.parametrize(
    ("state", "kind"), [("succeeded", "goal.reached"), ("aborted", "goal.failed"), ("canceled", "goal.canceled")]
)
def test_goals_are_reported_by_their_end(events: Heard, state: str, kind: str) -> None:
    goal = {"id": "g1", "state": state, "text": "x" * 1000}
    events.goal_ended(KEY, robot_request("tb1"), goal)
    [event] = events.all
    assert (event.type, event.robot, event.map, len(event.data["goal"]["text"])) == (kind, "tb1", "house", 400)
    events.goal_ended(KEY, None, goal | {"state": "active"})
    assert len(events.all) == 1


def test_tasks_are_reported_by_their_state(events: Heard) -> None:
    task = Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),), state="done", robot="tb1", leg=1, labels={"a": "b"})
    events.task_changed("ann", "house", task)
    [event] = events.all
    assert (event.type, event.user, event.robot, event.map) == ("task.done", "ann", "tb1", "house")
    assert (event.data["task"]["id"], event.data["task"]["visited"]) == ("t1", 1)


def test_faults_of_the_cloud_belong_to_no_user(events: Heard) -> None:
    events.container_lost("c1", robot_request("tb1"), "it exited with status 1")
    events.machine_lost("m1")
    events.disk_changed("full", "the disk is full")
    assert [(event.type, event.user, event.robot) for event in events.all] == [
        ("alert.container_lost", "", "tb1"), ("alert.machine_lost", "", ""), ("alert.disk_full", "", "")
    ]  # fmt: skip
    assert set(events.types) <= set(EVENT_TYPES)


def test_what_is_wrong_in_a_building_is_reported_to_its_owner_and_to_the_user_of_the_robot(events: Heard) -> None:
    inn = Building(floors=(Floor(name="L1", map="inn-1"), Floor(name="L2", map="inn-2")))
    for alert in (
        LiftAlert("north", "ann/tb1", "robot 'ann/tb1' does not leave"),
        DoorAlert("L2", "gate", "bob/tb2", "robot 'bob/tb2' stands in door 'gate'"),
        FaultChange(PartName("lift", "north"), "lift 'north' is in the mode 'fire'"),
        FaultChange(PartName("door", "gate", "L1"), ""),
    ):
        events.building_alerted(("bob", "inn"), inn, alert)
    assert [(event.type, event.user, event.robot, event.map) for event in events.all] == [
        ("lift.alert", "bob", "", ""), ("lift.alert", "ann", "tb1", ""), ("door.alert", "bob", "tb2", "inn-2"),
        ("lift.fault", "bob", "", ""), ("door.ok", "bob", "", "inn-1"),
    ]  # fmt: skip
    assert events.all[2].data == {
        "building": "inn", "owner": "bob", "door": "gate", "floor": "L2",
        "reason": "robot 'bob/tb2' stands in door 'gate'",
    }  # fmt: skip
    assert set(events.types) <= set(EVENT_TYPES)


def test_a_listener_that_fails_keeps_no_other_from_hearing(events: Heard) -> None:
    def fails(_: FleetEvent) -> None:
        raise ValueError("fault")

    later: list[FleetEvent] = []
    events.listen(fails)
    events.listen(later.append)
    events.machine_lost("m1")
    events.leave(fails)
    events.leave(fails)
    events.machine_lost("m2")
    assert [event.data["machine"] for event in later] == ["m1", "m2"]


# -- goals that other clients send -------------------------------------------------------------------------------------


def ends(place: StillRobot, goal: str, status: int = 3) -> None:
    place.publish_json("move_base/result", {"status": {"goal_id": {"id": goal}, "status": status, "text": "there"}})


def test_results_of_other_clients_are_heard_where_they_are_wanted(robots: Robots) -> None:
    heard: list[tuple[str, Any]] = []
    results = OtherGoals(robots, lambda key, goal: heard.append((key, goal)))  # type: ignore[arg-type]
    place = robots.open()
    results.place_opened(KEY)
    assert place.clients == 0
    results.hear({"ann"})
    for goal in ("mine", "rest-1", "task-1-0-0"):
        ends(place, goal)
    assert heard == [(KEY, {"id": "mine", "state": "succeeded", "text": "there"})]
    again = robots.open()
    results.place_opened(KEY)
    ends(again, "other", 4)
    assert heard[1:] == [(KEY, {"id": "other", "state": "aborted", "text": "there"})]
    assert place.clients == 0
    results.hear(set())
    assert again.clients == 0

"""Tasks in the process of a master: robots are sent, records follow, and a restart sends nothing twice."""

import json
from functools import partial
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import msgspec
import pytest
from msgspec import Raw

from engine.control.planning.requests import CostAnswer, CostRequest
from engine.control.robot_navigation import NavigationClient
from engine.control.tasks.group import KEPT_FOR, MOST_ENDED, OWN_KEPT_FOR, TaskGroup, obsolete
from engine.control.tasks.robots import TaskRobots
from engine.control.tasks.runner import LOOK, TaskNews, TaskRunner
from engine.control.tasks.task_maps import TaskMap, task_map_on
from engine.links.presence import RobotPresence
from engine.master.places import robot_key
from engine.protocols import robot_link
from engine.specs.containers import MapVersion
from engine.specs.robot_report import StateReport
from ppaas.clock import ManualClock
from ppaas.energy.battery import SAMPLES
from ppaas.energy.sites import NO_SITES, Sites
from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from ppaas.planners.weights import NEUTRAL
from ppaas.tasks.assignment import labels_of
from ppaas.tasks.dispatcher import GONE_AFTER
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.records import Task
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import MapTask
from tests.support.endpoints.still_place import StillRobot, delivered
from tests.support.engine.at_once import at_once
from tests.support.engine.specs import robot_request
from tests.support.geojson import collection, feature
from tests.support.storage.records import house, put_map, robot

GOAL, CANCEL = "move_base/goal", "move_base/cancel"


def in_metres(version: MapVersion, sites: Sites = NO_SITES) -> TaskMap:
    """Return a map on which the cost of a free path is its length [m]."""
    return TaskMap(version, sites, NEUTRAL)


class Hall:
    """Robots of ann on the map house, the store, and the runner of a master."""

    def __init__(self) -> None:
        self.clock = ManualClock(1000.0)
        self.store = MemoryStore()
        self.places: dict[str, StillRobot] = {}
        self.costs: list[list[float | None]] | None = None
        self.asked: list[CostRequest] = []
        self.start()

    def start(self) -> None:
        """Start a master, as after the end of another one."""
        self.presence = RobotPresence(self.places.get, self.clock)
        for key in self.places:
            self.presence.came(key)
        driver = SimpleNamespace(
            presence=self.presence,
            place=self.places.get,
            request_of=lambda key: robot_request(key.partition("/")[2]) if key in self.places else None,
        )
        self.news = TaskNews()
        self.robots = TaskRobots(driver, partial(NavigationClient, goal_ended=lambda _key, _goal: self.news.wake.set()))
        for key in self.places:
            self.robots.place_opened(key)
        self.runner = TaskRunner(self.store, self.robots, self.news, self.compute, self.clock, task_map=in_metres)

    async def compute(self, user: str, version: MapVersion, request: CostRequest) -> CostAnswer:
        self.asked.append(request)
        if self.costs is None:
            raise Unavailable("no machine has room")
        return CostAnswer(Raw(json.dumps(self.costs).encode()), 0.1, "c9", 9, version.id, version.version)

    def connect(self, name: str, **properties: Any) -> StillRobot:
        key = robot_key("ann", name)
        place = self.places[key] = StillRobot()
        place.container = "c"
        self.store.put_robot(robot(name, properties=properties))
        self.robots.place_opened(key)
        self.presence.came(key)
        return place

    def add(self, name: str, x: float, **fields: Any) -> None:
        given: dict[str, Any] = {"kind": "go_to", "places": ((x, 0.0, 0.0),), "created": self.clock()} | fields
        self.store.put_task(MapTask("ann", "house", Task(id=name, **given)))
        at_once(self.news.changed("ann", "house"))

    def group(self) -> TaskGroup:
        """Return the only group that is led."""
        [group] = self.runner._groups.values()
        return group

    def task(self, name: str) -> Task:
        return self.store.task("ann", "house", name).task

    async def after(self, seconds: float = 1.0) -> None:
        self.clock.advance(seconds)
        await self.runner.step()


def tell(place: StillRobot, x: float, *goals: tuple[str, Status]) -> None:
    """Let a robot tell where it is, and its goals."""
    pose = {"position": {"x": x, "y": 0.0}, "orientation": {"w": 1.0}}
    place.publish_json("amcl_pose", {"header": {"frame_id": "map"}, "pose": {"pose": pose}})
    statuses = [{"goal_id": {"id": goal}, "status": int(status)} for goal, status in goals]
    place.publish_json("move_base/status", {"status_list": statuses})


def report_of(place: StillRobot, **known: Any) -> None:
    """Let the container of a robot report something."""
    place.say(robot_link.ContainerBeat(busy=False, report=StateReport(**known)))


def ends(place: StillRobot, goal: str, status: Status, text: str = "") -> None:
    place.publish_json("move_base/result", {"status": {"goal_id": {"id": goal}, "status": int(status), "text": text}})


def goals(place: StillRobot) -> list[tuple[str, str]]:
    """Return the goals and cancellations that a robot has got since the last call."""
    found = []
    for topic, message in delivered(place):
        found.append((topic, message["goal_id"]["id"] if topic == GOAL else message["id"]))
    return found


@pytest.fixture
def hall() -> Hall:
    return Hall()


async def test_a_task_is_done_by_a_robot(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0, kind="pick_drop", places=((5.0, 0.0, 0.0), (9.0, 0.0, 0.0)))
    await hall.after()
    assert goals(place) == []
    tell(place, 0.0)
    await hall.after(5.0)
    assert goals(place) == [(GOAL, "task-t-0-0")]
    assert (hall.task("t").state, hall.task("t").robot) == ("assigned", "r")
    assert hall.runner.open_tasks() == {"assigned": 1}
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    assert hall.news.wake.is_set()
    await hall.after()
    assert goals(place) == [(GOAL, "task-t-1-0")]
    ends(place, "task-t-1-0", Status.SUCCEEDED)
    await hall.after()
    assert (hall.task("t").state, hall.task("t").ended) == ("done", hall.clock())
    assert hall.runner.open_tasks() == {}


async def test_the_matrix_of_costs_decides_who_goes(hall: Hall) -> None:
    near, far = hall.connect("near"), hall.connect("far")
    hall.costs = [[5.0], [100.0]]  # of the robots by name, far before near: a wall is in the way of the near one
    hall.add("t", 5.0)
    await hall.after()
    tell(near, 4.0)
    tell(far, 0.0)
    await hall.after(5.0)
    assert (goals(far), goals(near)) == ([(GOAL, "task-t-0-0")], [])
    assert hall.asked[-1].goals == ((5.0, 0.0, 0.0),)


async def test_straight_lines_decide_while_no_planning_container_answers(hall: Hall) -> None:
    near, far = hall.connect("near"), hall.connect("far")
    hall.add("t", 5.0)
    await hall.after()
    tell(near, 4.0)
    tell(far, 0.0)
    await hall.after(5.0)
    assert (goals(far), goals(near)) == ([], [(GOAL, "task-t-0-0")])
    assert hall.asked


async def test_labels_are_properties_of_robots(hall: Hall) -> None:
    near, far = hall.connect("near"), hall.connect("far", lift="yes", level=2, parts=[1])
    hall.add("t", 5.0, labels={"lift": "yes", "level": "2"})
    await hall.after()
    tell(near, 4.0)
    tell(far, 0.0)
    await hall.after(5.0)
    assert (goals(far), goals(near)) == ([(GOAL, "task-t-0-0")], [])
    assert labels_of({"a": "x", "b": True, "c": 1.5, "d": None, "e": []}) == {"a": "x", "b": "true", "c": "1.5"}


async def test_a_cancelled_task_stops_its_robot(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    kept = hall.store.task("ann", "house", "t")
    hall.store.put_task(msgspec.structs.replace(kept, task=msgspec.structs.replace(kept.task, state="cancelled")))
    goals(place)
    await hall.news.changed("ann", "house")
    await hall.after()
    assert goals(place) == [(CANCEL, "task-t-0-0")]
    assert hall.task("t").state == "cancelled"


async def test_a_confirmed_task_goes_on_and_its_dispatcher_is_not_made_again(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0, kind="patrol", places=((5.0, 0.0, 0.0), (9.0, 0.0, 0.0)), holds=(PlaceHold(confirm=True), None))
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    await hall.after()
    assert (hall.task("t").state, hall.task("t").holding, hall.task("t").leg) == ("active", hall.clock(), 0)
    goals(place)
    tell(place, 5.0)
    await hall.after(50.0)
    assert goals(place) == []
    dispatcher = hall.group()._dispatcher
    kept = hall.store.task("ann", "house", "t")
    hall.store.put_task(msgspec.structs.replace(kept, task=msgspec.structs.replace(kept.task, confirmed=0)))
    await hall.news.changed("ann", "house")
    tell(place, 5.0)
    await hall.after()
    assert goals(place) == [(GOAL, "task-t-1-0")]
    assert hall.group()._dispatcher is dispatcher


async def test_a_button_of_the_robot_confirms_what_it_holds_for_and_nothing_else(hall: Hall) -> None:
    place = hall.connect("r")
    report_of(place, confirmations=3)
    holds = (PlaceHold(confirm=True), PlaceHold(confirm=True))
    hall.add("t", 5.0, kind="patrol", places=((5.0, 0.0, 0.0), (9.0, 0.0, 0.0)), holds=holds)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    report_of(place, confirmations=4)  # on its way
    await hall.after()
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    for _ in range(2):
        await hall.after()
    assert hall.task("t").needs_confirmation
    report_of(place, confirmations=5)
    await hall.after()
    assert goals(place)[-1] == (GOAL, "task-t-1-0")
    ends(place, "task-t-1-0", Status.SUCCEEDED)
    for count in (0, 0, 1):  # of its next container
        report_of(place, confirmations=count)
        await hall.after()
    assert hall.task("t").state == "done"


async def test_a_confirmation_survives_a_restart(hall: Hall) -> None:
    hall.connect("r")
    holds = (PlaceHold(confirm=True), None)
    places = ((5.0, 0.0, 0.0), (9.0, 0.0, 0.0))
    hall.add("t", 5.0, kind="patrol", places=places, holds=holds, state="active", robot="r", holding=900.0, confirmed=0)
    hall.start()
    await hall.after()
    tell(hall.places[robot_key("ann", "r")], 5.0)
    await hall.after()
    assert goals(hall.places[robot_key("ann", "r")]) == [(GOAL, "task-t-1-0")]


async def test_the_next_run_of_a_task_is_stored_once(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0, repeat=Repeat(every=60.0))
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    await hall.after()
    assert (hall.task("t").state, hall.task("t-2").state, hall.task("t-2").not_before) == ("done", "queued", 1060.0)
    cancelled = hall.store.task("ann", "house", "t-2")
    hall.store.put_task(
        msgspec.structs.replace(cancelled, task=msgspec.structs.replace(cancelled.task, state="cancelled"))
    )
    first = hall.store.task("ann", "house", "t")
    hall.store.put_task(
        msgspec.structs.replace(first, task=msgspec.structs.replace(first.task, state="assigned", leg=0))
    )
    hall.start()  # as if the master had been killed between both records
    await hall.after()
    for status in (Status.ACTIVE, Status.SUCCEEDED):
        tell(place, 5.0, ("task-t-0-0", status))
        await hall.after()
    assert (hall.task("t").state, hall.task("t-2").state) == ("done", "cancelled")


async def test_a_task_begins_after_the_end_of_another_that_is_kept_as_long(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("a", 5.0, state="done", ended=-KEPT_FOR)
    hall.add("b", 9.0, after=(After(task="a"),))
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    assert goals(place) == [(GOAL, "task-b-0-0")]
    assert obsolete([ended("a", 0.0), ended("c", 0.0), hall.task("b")], 2 * KEPT_FOR) == ["c"]


async def test_a_task_that_was_cancelled_just_now_is_not_written_over(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    kept = hall.store.task("ann", "house", "t")
    hall.store.put_task(msgspec.structs.replace(kept, task=msgspec.structs.replace(kept.task, state="cancelled")))
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    for _ in range(3):
        await hall.after()
    assert hall.task("t").state == "cancelled"


async def test_another_master_goes_on_and_sends_the_goal_of_the_record_again(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    hall.add("gone", 6.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    assert goals(place) == [(GOAL, "task-t-0-0")]
    hall.robots.close()
    hall.start()
    await hall.after()
    tell(place, 1.0, ("task-t-0-0", Status.ACTIVE), ("task-old-0-0", Status.ACTIVE))
    await hall.after()
    assert goals(place) == [(GOAL, "task-t-0-0"), (CANCEL, "task-old-0-0")]
    tell(place, 5.0, ("task-t-0-0", Status.SUCCEEDED))
    await hall.after()
    assert hall.task("t").state == "done"


async def test_a_robot_that_leaves_gives_its_task_to_another(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    del hall.places[robot_key("ann", "r")]
    other = hall.connect("s")
    await hall.after()
    tell(other, 0.0)
    await hall.after(GONE_AFTER + 1.0)
    await hall.after(5.0)
    assert goals(other) == [(GOAL, "task-t-0-1")]


async def test_a_robot_that_left_gets_no_task_while_its_container_waits_for_it(hall: Hall) -> None:
    place = hall.connect("r")
    tell(place, 0.0)
    hall.presence.left(robot_key("ann", "r"))
    hall.add("t", 5.0)
    for _ in range(10):
        await hall.after(5.0)
        tell(place, 0.0)
    assert (goals(place), hall.task("t").state) == ([], "queued")
    hall.presence.came(robot_key("ann", "r"))
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    assert goals(place) == [(GOAL, "task-t-0-0")]


async def test_a_task_returns_its_time_after_the_loss_of_its_robot_and_not_after_the_end_of_its_container(
    hall: Hall,
) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    hall.presence.left(robot_key("ann", "r"))
    goals(place)
    await hall.after(GONE_AFTER)
    assert hall.task("t").state == "assigned"
    await hall.after()
    assert (hall.task("t").state, hall.task("t").failures) == ("queued", 0)
    assert goals(place) == [(CANCEL, "task-t-0-0")]  # its clone still runs


async def test_records_that_are_read_again_do_not_delay_the_return_of_a_task(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    hall.presence.left(robot_key("ann", "r"))
    await hall.after(20.0)
    hall.group()._forget()
    await hall.after(GONE_AFTER - 20.0 + 1.0)
    assert hall.task("t").state == "queued"


async def test_a_goal_that_the_clone_gives_up_while_its_robot_is_away_is_sent_again_and_no_failure(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    hall.presence.left(robot_key("ann", "r"))
    await hall.after()
    goals(place)
    ends(place, "task-t-0-0", Status.ABORTED, "no progress")
    await hall.after()
    assert (goals(place), hall.task("t").state, hall.task("t").failures) == ([], "assigned", 0)
    hall.presence.came(robot_key("ann", "r"))
    await hall.after()
    assert goals(place) == [(GOAL, "task-t-0-1")]


async def test_a_place_that_is_opened_again_gets_the_goal_again(hall: Hall) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    place.close(Unavailable("it was moved"))
    again = hall.connect("r")
    await hall.after()
    assert goals(again) == [(GOAL, "task-t-0-0")]
    assert hall.task("t").failures == 0


async def test_a_store_that_fails_loses_nothing(hall: Hall, monkeypatch: pytest.MonkeyPatch) -> None:
    place = hall.connect("r")
    hall.add("t", 5.0)
    await hall.after()
    tell(place, 0.0)

    def fails(*_: Any, **__: Any) -> None:
        raise Unavailable("the disk is full")

    with monkeypatch.context() as broken:
        broken.setattr(hall.store, "put_task", fails)
        with pytest.raises(Unavailable):
            await hall.after(5.0)
    assert goals(place) == []
    await hall.after()
    assert goals(place) == [(GOAL, "task-t-0-0")]


async def test_robots_are_followed_only_while_there_are_tasks(hall: Hall) -> None:
    place = hall.connect("r")
    await hall.after()
    assert place.clients == 0
    hall.add("t", 5.0)
    await hall.after()
    assert place.clients == 1
    hall.store.remove_tasks("house")
    await hall.news.changed("ann", "house")
    await hall.after()
    for _ in range(2):
        await hall.after(61.0)
    assert place.clients == 0


async def test_robots_are_seldom_looked_at_while_there_are_no_tasks(
    hall: Hall, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = hall.connect("r")
    await hall.after()
    looked = Mock(wraps=hall.robots.connected)
    monkeypatch.setattr(hall.robots, "connected", looked)
    await hall.after(LOOK - 1.0)
    looked.assert_not_called()
    await hall.after()
    looked.assert_called()
    assert place.clients == 0
    hall.add("t", 5.0)
    await hall.after()
    assert looked.call_count > 1


async def test_robots_charge_before_the_first_task(hall: Hall) -> None:
    task_map = partial(in_metres, sites=Sites({"c": (3.0, 0.0, 0.0)}))
    hall.runner = TaskRunner(hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=task_map)
    place = hall.connect("r")
    report_battery(place, 0.2)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    [trip] = [one.task for one in hall.store.tasks("ann", "house")]
    assert (trip.trip, goals(place)) == ("charge", [(GOAL, trip.goal_id)])


async def test_a_robot_that_somebody_else_docks_is_left_to_that(hall: Hall) -> None:
    task_map = partial(in_metres, sites=Sites({"c": (3.0, 0.0, 0.0)}))
    hall.runner = TaskRunner(hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=task_map)
    place = hall.connect("r")
    place.topics[DOCK_ROBOT.goal.name] = robot_link.TopicInfo(DOCK_ROBOT.goal.name, "nav2_msgs/ActionGoal", False)
    report_battery(place, 0.2)
    await hall.after()
    for state, trips in ((Status.ACTIVE, 0), (Status.ABORTED, 1)):
        tell(place, 0.0)
        status = {"goal_id": {"id": "ours"}, "status": int(state)}
        place.publish_json(DOCK_ROBOT.status.name, {"status_list": [status]})
        await hall.after(5.0)
        assert len(hall.store.tasks("ann", "house")) == trips


def ended(name: str, at: float) -> Task:
    return Task(id=name, kind="go_to", places=((0.0, 0.0, 0.0),), state="done", ended=at)


def test_tasks_are_removed_some_days_after_their_end() -> None:
    waiting = Task(id="w", kind="go_to", places=((0.0, 0.0, 0.0),))
    assert obsolete([ended("old", 0.0), ended("new", 5.0), waiting], KEPT_FOR + 3.0) == ["old"]


def test_of_many_tasks_the_oldest_are_removed() -> None:
    tasks = [ended(f"t{number}", float(number)) for number in range(MOST_ENDED + 2)]
    assert sorted(obsolete(tasks, 2000.0)) == ["t0", "t1"]


def report_battery(place: StillRobot, charge: float) -> None:
    place.say(robot_link.ContainerBeat(busy=False, report=StateReport(battery=charge)))


async def test_robots_charge_at_docks_of_their_map_also_when_all_tasks_are_done(hall: Hall) -> None:
    read: list[MapVersion] = []

    def task_map(version: MapVersion) -> TaskMap:
        read.append(version)
        return in_metres(version, Sites({"dock": (3.0, 0.0, 0.0)}))

    hall.runner = TaskRunner(hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=task_map)
    place = hall.connect("r")
    report_battery(place, 0.2)
    hall.add("t", 5.0, state="done", ended=hall.clock())
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    [record] = [one for one in hall.store.tasks("ann", "house") if one.task.trip == "charge"]
    trip = record.task
    assert (trip.state, trip.robot, trip.places) == ("assigned", "r", ((3.0, 0.0, 0.0),))
    assert goals(place) == [(GOAL, trip.goal_id)]
    ends(place, trip.goal_id, Status.SUCCEEDED)
    await hall.after()
    assert hall.task(trip.id).holding == hall.clock()
    for _ in range(SAMPLES):
        tell(place, 3.0)
        report_battery(place, 0.97)
        await hall.after(100.0)
    assert hall.task(trip.id).state == "done"
    assert len(read) == 1


async def test_what_a_robot_drives_teaches_what_its_battery_does(hall: Hall) -> None:
    hall.start()
    hall.robots._monotonic = hall.clock
    place = hall.connect("r")
    hall.add("t", 5.0, not_before=1e11)
    await hall.after()
    for number in range(1200):  # a metre in two seconds costs a thousandth
        hall.clock.advance(2.0)
        tell(place, float(number), ("other", Status.ACTIVE))
        report_battery(place, 1.0 - number / 1000.0 if number < 900 else 0.1)
        if number < 900:
            await hall.runner.step()
    battery = hall.robots.now("ann", "r", {}).battery
    assert battery is not None
    assert battery.cost(100.0, 200.0) == pytest.approx(0.1, rel=0.1)
    report_battery(place, 0.5)
    place.say(robot_link.ContainerBeat(busy=False, report=StateReport()))
    assert hall.robots.now("ann", "r", {}).battery is None


def test_docks_and_cells_are_read_from_a_version() -> None:
    maps = MemoryMapStore()
    version = MapVersion("house", "v9")
    assert task_map_on(maps, version) == TaskMap(version, NO_SITES, None)
    point = {"type": "Point", "coordinates": [0.0, 0.0]}
    zones = collection(feature(point, name="a", kind="dock", yaw=0.5))
    record = put_map(maps, house(zones=zones))
    found = task_map_on(maps, MapVersion(record.id, record.version))
    assert (found.sites.chargers, found.resolution) == ({"a": (0.0, 0.0, 0.5)}, 0.05)


async def test_changes_of_tasks_are_reported_once(hall: Hall) -> None:
    heard: list[tuple[str, str, str, str]] = []

    def changed(user: str, map_id: str, task: Task) -> None:
        heard.append((user, map_id, task.id, task.state))

    hall.runner = TaskRunner(hall.store, hall.robots, hall.news, hall.compute, hall.clock, changed=changed)
    place = hall.connect("tb1")
    hall.add("t1", 1.0)
    hall.add("t2", 9.0, priority=-1)
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    assert heard == [("ann", "house", "t1", "assigned")]
    kept = hall.store.task("ann", "house", "t2")
    hall.store.put_task(msgspec.structs.replace(kept, task=msgspec.structs.replace(kept.task, state="cancelled")))
    await hall.news.changed("ann", "house")
    await hall.after()
    await hall.news.changed("ann", "house")
    await hall.after()
    ends(place, "task-t1-0-0", Status.SUCCEEDED)
    await hall.after()
    assert heard[1:] == [("ann", "house", "t2", "cancelled"), ("ann", "house", "t1", "done")]


async def test_ended_tasks_are_kept_for_the_time_that_is_set(hall: Hall) -> None:
    hall.runner = TaskRunner(hall.store, hall.robots, hall.news, hall.compute, hall.clock, kept_for=10.0)
    hall.add("t1", 1.0, state="done", ended=hall.clock())
    await hall.after(9.0)
    assert hall.store.tasks("ann", "house")
    await hall.news.changed("ann", "house")
    await hall.after(2.0)
    assert hall.store.tasks("ann", "house") == []


async def test_another_time_holds_for_all_ended_tasks(hall: Hall) -> None:
    hall.add("t1", 1.0, state="done", ended=hall.clock())
    hall.add("t2", 2.0)
    await hall.after(9.0)
    hall.runner.keep_for(10.0)
    await hall.news.changed("ann", "house")
    await hall.after(2.0)
    assert [record.task.id for record in hall.store.tasks("ann", "house")] == ["t2"]


async def test_robots_dock_at_docks_and_undock_before_their_next_task(hall: Hall) -> None:
    sites = Sites({"a": (3.0, 0.0, 0.0)}, docks={"a": "a"})
    hall.runner = TaskRunner(
        hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=partial(in_metres, sites=sites)
    )
    place = hall.connect("r")
    for topic in (DOCK_ROBOT.goal.name, UNDOCK_ROBOT.goal.name):
        place.topics[topic] = robot_link.TopicInfo(topic, "nav2_msgs/ActionGoal", False)
    report_battery(place, 0.2)
    hall.add("done", 5.0, state="done", ended=hall.clock())
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    [trip] = [one.task for one in hall.store.tasks("ann", "house") if one.task.trip]
    [(topic, message)] = delivered(place)
    assert (topic, message["goal_id"]["id"], message["goal"]["dock_id"]) == (DOCK_ROBOT.goal.name, trip.goal_id, "a")
    status = {"goal_id": {"id": trip.goal_id}, "status": int(Status.SUCCEEDED), "text": ""}
    place.publish_json(DOCK_ROBOT.result.name, {"status": status})
    await hall.after()
    assert hall.task(trip.id).holding == hall.clock()
    for _ in range(SAMPLES):
        tell(place, 3.0)
        place.say(robot_link.ContainerBeat(busy=False, report=StateReport(battery=0.97, docked="docked at dock 'a'")))
        await hall.after()
    assert hall.task(trip.id).state == "done"
    hall.add("t", 5.0)
    await hall.after()
    assert [topic for topic, _ in delivered(place)] == [UNDOCK_ROBOT.goal.name]
    place.publish_json(UNDOCK_ROBOT.result.name, {"status": status | {"goal_id": {"id": "task-t-0-0"}}})
    assert goals(place) == [(GOAL, "task-t-0-0")]
    ends(place, "task-t-0-0", Status.SUCCEEDED)
    await hall.after()
    assert hall.task("t").state == "done"


async def test_a_robot_whose_trip_to_a_dock_is_cancelled_docks_no_longer(hall: Hall) -> None:
    sites = Sites({"a": (3.0, 0.0, 0.0)}, docks={"a": "a"})
    hall.runner = TaskRunner(
        hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=partial(in_metres, sites=sites)
    )
    place = hall.connect("r")
    place.topics[DOCK_ROBOT.goal.name] = robot_link.TopicInfo(DOCK_ROBOT.goal.name, "nav2_msgs/ActionGoal", False)
    report_battery(place, 0.2)
    hall.add("done", 5.0, state="done", ended=hall.clock())
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    [trip] = [one for one in hall.store.tasks("ann", "house") if one.task.trip]
    assert [topic for topic, _ in delivered(place)] == [DOCK_ROBOT.goal.name]
    ended = msgspec.structs.replace(trip.task, state="cancelled", ended=hall.clock())
    hall.store.put_task(msgspec.structs.replace(trip, task=ended))
    await hall.news.changed("ann", "house")
    await hall.after()
    assert (DOCK_ROBOT.cancel.name, {"stamp": {"secs": 0, "nsecs": 0}, "id": trip.task.goal_id}) in delivered(place)


@pytest.mark.parametrize("text", ["contact-without-charge: no current", "charger-lies: the battery is discharged"])
async def test_a_robot_that_cannot_dock_goes_to_the_next_charger_and_that_is_an_event(hall: Hall, text: str) -> None:
    sites = Sites({"a": (3.0, 0.0, 0.0), "b": (9.0, 0.0, 0.0)}, docks={"a": "a", "b": "b"})
    told: list[tuple[str, str]] = []
    hall.runner = TaskRunner(
        hall.store, hall.robots, hall.news, hall.compute, hall.clock, task_map=partial(in_metres, sites=sites),
        changed=lambda _user, _map, task: told.append((task.state, task.reason)),
    )  # fmt: skip
    place = hall.connect("r")
    place.topics[DOCK_ROBOT.goal.name] = robot_link.TopicInfo(DOCK_ROBOT.goal.name, "nav2_msgs/ActionGoal", False)
    report_battery(place, 0.2)
    hall.add("done", 5.0, state="done", ended=hall.clock())
    await hall.after()
    tell(place, 0.0)
    await hall.after(5.0)
    [(_, first)] = delivered(place)
    status = {"goal_id": first["goal_id"], "status": int(Status.ABORTED), "text": text}
    place.publish_json(DOCK_ROBOT.result.name, {"status": status})
    await hall.after()
    [(_, second)] = delivered(place)
    assert (first["goal"]["dock_id"], second["goal"]["dock_id"]) == ("a", "b")
    assert ("failed", f"robot 'r': goal aborted: {text}") in told


async def test_what_was_learnt_of_a_battery_survives_a_restart(hall: Hall) -> None:
    hall.connect("r")
    learnt = (3e-4, 4e-5, 5e-4)
    trip = {"trip": "charge", "state": "done", "robot": "r", "named_robot": "r", "ended": hall.clock()}
    hall.add("old", 3.0, **trip | {"created": 0.0}, learnt=(1e-4, 1e-5, 1e-4))
    hall.add("new", 3.0, **trip, learnt=learnt)
    hall.add("park", 3.0, **trip | {"trip": "park", "created": 5000.0})
    hall.start()
    place = hall.places[robot_key("ann", "r")]
    await hall.after()
    tell(place, 0.0)
    report_battery(place, 0.8)
    await hall.after()
    battery = hall.robots.now("ann", "r", {}).battery
    assert battery is not None and battery.learnt == pytest.approx(learnt)
    await hall.after(2.0 * OWN_KEPT_FOR)
    await hall.news.changed("ann", "house")
    await hall.after()
    assert [one.task.id for one in hall.store.tasks("ann", "house")] == ["new"]

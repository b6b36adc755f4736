"""Tasks over floors: one dispatcher for all floors, journeys with the ids of goals, and lifts that are left first."""

from collections.abc import Sequence

import pytest
from msgspec.structs import replace

from engine.control.journeys.leader import view_of
from engine.control.planning.building_requests import BuildingSpot
from engine.control.tasks.runner import TaskRunner
from engine.control.tasks.task_maps import TaskMap
from engine.control.views import GoalView
from engine.master.places import robot_key
from engine.protocols import robot_link
from engine.specs.containers import MapVersion
from engine.specs.robot_report import StateReport
from ppaas.buildings.building import Building, Floor
from ppaas.buildings.journeys.records import Journey, JourneyState, Phase
from ppaas.energy.battery import SAMPLES
from ppaas.energy.sites import Sites
from ppaas.errors import InvalidBuilding
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from ppaas.tasks.dispatcher import GONE_AFTER
from ppaas.tasks.records import Task
from ppaas.tasks.ways import NO_WAY
from storage.buildings.records import BuildingRecord, BuildingVersion, no_building_of
from storage.records import MapTask
from tests.support.endpoints.still_place import StillRobot, delivered
from tests.support.engine.at_once import at_once
from tests.support.engine.specs import robot_request
from tests.unit.engine.control.tasks.test_runner import CANCEL, GOAL, Hall, goals, in_metres, report_battery, tell

HOTEL = Building(floors=(Floor(name="L1", map="house"), Floor(name="L2", map="loft", elevation=3.0)))
BOTH = ("L1", "L2")


class Journeys:
    """Journeys as the leader knows them, in states that the test sets."""

    def __init__(self) -> None:
        self.led: dict[str, Journey] = {}
        self.is_known = True
        self.seconds: list[list[float | None]] = []
        self.asked: list[tuple[Sequence[BuildingSpot], Sequence[BuildingSpot]]] = []

    def of_robot(self, user: str, robot: str) -> list[Journey]:
        return [journey for journey in self.led.values() if (journey.user, journey.robot) == (user, robot)]

    async def lead(self, user: str, robot: str, floor: str, pose: Pose2D, *, goal_id: str = "") -> Journey:
        if not self.is_known:
            raise no_building_of("house")
        HOTEL.floor(floor)
        made = Journey(id=goal_id, user=user, robot=robot, building="hotel", floor=floor, goal=tuple(pose), on="L1")
        return self.led.setdefault(goal_id, made)

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        journey = self.led[goal_id]
        assert (journey.user, journey.robot, journey.state) == (user, robot, "active")
        self.set(goal_id, "active" if journey.is_aboard else "canceled", journey.phase)
        return view_of(self.led[goal_id])

    async def times(
        self, user: str, map_id: str, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> list[list[float | None]]:
        self.asked.append((starts, goals))
        return self.seconds

    def set(self, goal_id: str, state: JourneyState, phase: Phase = "driving", text: str = "") -> None:
        self.led[goal_id] = replace(self.led[goal_id], state=state, phase=phase, text=text)


class Tower(Hall):
    """Two floors, on whose maps robots are by name."""

    def __init__(self) -> None:
        self.journeys = Journeys()
        self.on: dict[str, str] = {}
        super().__init__()
        version = BuildingVersion(number=1, building=HOTEL, author="ann", created=1.0)
        self.store.put_building(BuildingRecord(user="ann", id="hotel", present=version))

    def start(self) -> None:
        super().start()
        self.robots._places.request_of = self.request_of  # type: ignore[method-assign]
        for key in self.places:
            self.robots.place_opened(key)
        self.runner = TaskRunner(
            self.store, self.robots, self.news, self.compute, self.clock, journeys=self.journeys, task_map=in_metres
        )

    def request_of(self, key: str) -> object:
        name = key.partition("/")[2]
        version = MapVersion(self.on.get(name, "house"), "v1")
        return robot_request(name, version=version) if key in self.places else None

    def cancel(self, name: str) -> None:
        kept = self.store.task("ann", "house", name)
        self.store.put_task(replace(kept, task=replace(kept.task, state="cancelled")), instead_of=kept)
        at_once(self.news.changed("ann", "house"))


@pytest.fixture
def tower() -> Tower:
    return Tower()


def over(tower: Tower, name: str, *floors: str, **fields: object) -> None:
    """Add a task to floors, at x = 5 m on each."""
    kind = "go_to" if len(floors) == 1 else "patrol"
    tower.add(name, 5.0, kind=kind, places=((5.0, 0.0, 0.0),) * len(floors), floors=floors, **fields)


async def begun(tower: Tower, *floors: str, **fields: object) -> StillRobot:
    """Return a robot on L1 that has got a task to floors."""
    place = tower.connect("r")
    tower.journeys.seconds = [[10.0]]
    over(tower, "t", *floors, **fields)
    await tower.after()
    tell(place, 0.0)
    await tower.after(5.0)
    return place


async def test_a_task_over_floors_is_led_by_journeys_and_stays_with_its_robot(tower: Tower) -> None:
    place = await begun(tower, "L2", "L1")
    [journey] = tower.journeys.of_robot("ann", "r")
    assert (journey.id, journey.floor, journey.goal) == ("task-t-0-0", "L2", (5.0, 0.0, 0.0))
    assert (goals(place), tower.task("t").state, tower.task("t").home) == ([], "assigned", "")
    tower.on["r"] = "loft"  # behind the doors of the lift
    tell(place, 5.0, ("task-t-0-0/7", Status.ACTIVE))
    await tower.after()
    assert (goals(place), tower.task("t").robot) == ([], "r")
    tower.journeys.set("task-t-0-0", "succeeded")
    await tower.after()
    assert (tower.task("t").state, tower.task("t").leg) == ("active", 1)
    assert [each.floor for each in tower.journeys.of_robot("ann", "r")] == ["L2", "L1"]
    tower.journeys.set("task-t-1-0", "succeeded")
    await tower.after()
    assert tower.task("t").state == "done"


async def test_the_times_over_floors_decide_and_a_robot_on_another_floor_may_be_the_nearest(tower: Tower) -> None:
    near, far = tower.connect("near"), tower.connect("far")
    tower.on["far"] = "loft"
    tower.journeys.seconds = [[20.0], [200.0]]  # of far and near
    over(tower, "t", "L1")
    await tower.after()
    tell(near, 4.0)
    tell(far, 0.0)
    await tower.after(5.0)
    assert tower.task("t").robot == "far"
    starts, ends_at = tower.journeys.asked[-1]
    assert ([spot.floor for spot in starts], [spot.floor for spot in ends_at]) == (["L2", "L1"], ["L1"])


async def test_a_task_without_floors_is_done_by_robots_on_its_map_alone(tower: Tower) -> None:
    other = tower.connect("other")
    tower.on["other"] = "loft"
    tower.add("t", 5.0)
    await tower.after()
    tell(other, 5.0)
    await tower.after(5.0)
    assert (goals(other), tower.task("t").state) == ([], "queued")
    here = tower.connect("here")
    await tower.after()
    tell(here, 0.0)
    tell(other, 5.0)
    await tower.after(5.0)
    assert (goals(here), goals(other), tower.journeys.led) == ([(GOAL, "task-t-0-0")], [], {})
    assert (tower.asked[-1].starts, tower.journeys.asked) == (((0.0, 0.0, 0.0),), [])


async def test_a_task_to_which_no_way_leads_waits_and_says_so_until_there_is_one(tower: Tower) -> None:
    place = tower.connect("r")
    tower.journeys.seconds = [[None]]  # the lift is out of order
    over(tower, "t", "L2")
    await tower.after()
    tell(place, 0.0)
    await tower.after(5.0)
    assert (tower.task("t").state, tower.task("t").reason) == ("queued", NO_WAY)
    tower.journeys.seconds = [[60.0]]
    tell(place, 0.0)
    await tower.after(5.0)
    assert (tower.task("t").state, tower.task("t").reason) == ("assigned", "")


async def test_a_floor_that_the_building_has_no_longer_fails_a_task(tower: Tower) -> None:
    with pytest.raises(InvalidBuilding):
        HOTEL.floor("L9")
    place = await begun(tower, "L9")
    for _ in range(2):
        for _ in range(4):
            await tower.after(5.0)
            tell(place, 0.0)
    await tower.after(5.0)
    assert (tower.task("t").state, tower.task("t").failures) == ("failed", 3)
    assert "there is no floor 'L9'" in tower.task("t").reason


async def test_a_journey_that_fails_fails_the_leg_with_its_text(tower: Tower) -> None:
    await begun(tower, "L2")
    tower.journeys.set("task-t-0-0", "failed", text="no route leads there")
    await tower.after()
    assert (tower.task("t").state, tower.task("t").failures) == ("queued", 1)
    assert tower.task("t").reason == "robot 'r': goal aborted: no route leads there"


@pytest.mark.parametrize("phase", ["driving", "inside"])
async def test_a_cancelled_task_ends_its_journey_and_a_robot_leaves_a_lift_before_its_next_task(
    tower: Tower, phase: Phase
) -> None:
    place = await begun(tower, "L2")
    tower.journeys.set("task-t-0-0", "active", phase)
    tower.cancel("t")
    tower.add("next", 7.0)
    await tower.after()
    if phase == "inside":
        for _ in range(3):
            tell(place, 0.0)
            await tower.after(5.0)
        assert tower.task("next").state == "queued"
        tower.journeys.set("task-t-0-0", "canceled")
    tell(place, 0.0)
    await tower.after(5.0)
    assert [each.state for each in tower.journeys.led.values()] == ["canceled"]
    assert goals(place) == [(GOAL, "task-next-0-0")]


@pytest.mark.parametrize("floors", [(), ("L1",)])
async def test_a_task_that_preempts_waits_until_the_robot_is_out_of_the_lift(
    tower: Tower, floors: tuple[str, ...]
) -> None:
    place = await begun(tower, "L1", "L2")
    tower.journeys.set("task-t-0-0", "succeeded")
    await tower.after()
    goal = "task-t-1-0"
    tower.journeys.set(goal, "active", "inside")
    tower.add("first", 7.0, priority=9, preempts=True, floors=floors)
    for _ in range(2):
        tell(place, 0.0, (f"{goal}/4", Status.ACTIVE))
        await tower.after(5.0)
    assert (tower.task("first").robot, tower.task("t").state) == ("r", "queued")
    assert (goals(place), "task-first-0-0" in tower.journeys.led) == ([], False)
    tower.journeys.set(goal, "canceled")
    tell(place, 0.0)
    await tower.after()
    assert (goals(place), "task-first-0-0" in tower.journeys.led) == (
        ([], True) if floors else ([(GOAL, "task-first-0-0")], False)
    )


async def test_a_robot_that_is_silent_in_a_lift_keeps_its_task(tower: Tower) -> None:
    await begun(tower, "L2")
    tower.journeys.set("task-t-0-0", "active", "inside")
    tower.presence.left(robot_key("ann", "r"))
    for _ in range(3):
        await tower.after(GONE_AFTER + 1.0)
    assert (tower.task("t").state, tower.task("t").robot) == ("assigned", "r")
    tower.journeys.set("task-t-0-0", "active")
    await tower.after(GONE_AFTER + 1.0)
    assert tower.task("t").state == "queued"


async def test_another_master_leads_a_robot_by_the_same_goal(tower: Tower) -> None:
    place = await begun(tower, "L2")
    tower.on["r"] = "loft"
    tower.robots.close()
    tower.start()
    for _ in range(2):
        tell(place, 0.0, ("task-t-0-0/3", Status.ACTIVE), ("task-old-0-0/1", Status.ACTIVE))
        await tower.after()
    assert (list(tower.journeys.led), goals(place)) == (["task-t-0-0"], [(CANCEL, "task-old-0-0")])
    tower.journeys.set("task-t-0-0", "succeeded")
    tell(place, 0.0)
    await tower.after()
    assert tower.task("t").state == "done"


async def test_a_building_that_was_removed_fails_its_tasks_over_floors_and_sends_nobody(tower: Tower) -> None:
    place = await begun(tower, "L2")
    assert len(tower.group().area.maps) == len(HOTEL.floors)
    tower.store.remove_building("ann", "hotel")
    tower.journeys.set("task-t-0-0", "failed", text="it is gone")
    tower.journeys.is_known = False
    tower.store.put_task(MapTask("ann", "loft", Task(id="u", kind="go_to", places=((5.0, 0.0, 0.0),))))
    for _ in range(15):
        tell(place, 0.0)
        await tower.after(5.0)
    assert {area.maps for area in tower.runner._groups} == {(("", "house"),), (("", "loft"),)}
    assert (tower.task("t").state, tower.task("t").failures) == ("failed", 3)
    assert ("no floor of a building" in tower.task("t").reason, goals(place)) == (True, [])


async def test_a_robot_on_a_journey_of_a_user_gets_no_task_also_while_it_waits_for_a_lift(tower: Tower) -> None:
    place = tower.connect("r")
    await tower.journeys.lead("ann", "r", "L2", Pose2D(1.0, 2.0), goal_id="journey-1")
    tower.journeys.set("journey-1", "active", "waiting")
    tower.add("t", 5.0)
    await tower.after()
    for _ in range(3):
        tell(place, 0.0)
        await tower.after(5.0)
    assert (goals(place), tower.task("t").state) == ([], "queued")
    tower.journeys.set("journey-1", "succeeded")
    tell(place, 0.0)
    await tower.after(5.0)
    assert goals(place) == [(GOAL, "task-t-0-0")]


async def test_a_journey_of_a_task_that_was_cancelled_while_no_master_led_ends(tower: Tower) -> None:
    place = tower.connect("r")
    await tower.journeys.lead("ann", "r", "L2", Pose2D(1.0, 2.0), goal_id="task-old-0-0")
    tower.add("t", 5.0)
    for _ in range(2):
        await tower.after(5.0)
        tell(place, 0.0)
    assert tower.journeys.led["task-old-0-0"].state == "canceled"


async def test_two_tasks_to_one_floor_are_given_to_two_robots_by_the_times_of_both(tower: Tower) -> None:
    one, other = tower.connect("one"), tower.connect("other")
    tower.on["other"] = "loft"
    tower.journeys.seconds = [[90.0], [10.0]]  # both tasks have one place
    over(tower, "a", "L2")
    over(tower, "b", "L2")
    await tower.after()
    tell(one, 0.0)
    tell(other, 0.0)
    await tower.after(5.0)
    assert {tower.task("a").robot, tower.task("b").robot} == {"one", "other"}
    assert {(journey.robot, journey.floor) for journey in tower.journeys.led.values()} == {
        ("one", "L2"), ("other", "L2"),
    }  # fmt: skip


async def test_a_robot_charges_at_a_dock_of_another_floor_and_undocks_before_it_rides_on(tower: Tower) -> None:
    links = frozenset({"north"})
    sites = {"house": Sites(), "loft": Sites({"a": (3.0, 0.0, 0.0)}, docks={"a": "a"})}
    tower.runner = TaskRunner(
        tower.store, tower.robots, tower.news, tower.compute, tower.clock, journeys=tower.journeys,
        task_map=lambda version: TaskMap(version, sites[version.id], 1.0, links),
    )  # fmt: skip
    place = tower.connect("r")
    for topic in (DOCK_ROBOT.goal.name, UNDOCK_ROBOT.goal.name):
        place.topics[topic] = robot_link.TopicInfo(topic, "nav2_msgs/ActionGoal", False)
    report_battery(place, 0.2)
    over(tower, "done", "L2", state="done", ended=tower.clock())
    await tower.after()
    tell(place, 0.0)
    await tower.after(5.0)
    [journey] = tower.journeys.of_robot("ann", "r")
    assert (journey.floor, journey.goal) == ("L2", (2.0, 0.0, 0.0)), "before the dock"
    tower.on["r"] = "loft"
    tell(place, 2.0)
    tower.journeys.set(journey.id, "succeeded")
    await tower.after()
    [(topic, message)] = delivered(place)
    assert (topic, message["goal_id"]["id"], message["goal"]["dock_id"]) == (DOCK_ROBOT.goal.name, journey.id, "a")
    status = {"goal_id": {"id": journey.id}, "status": int(Status.SUCCEEDED), "text": ""}
    place.publish_json(DOCK_ROBOT.result.name, {"status": status})
    await tower.after()
    trip = journey.id.removeprefix("task-").removesuffix("-0-0")
    [holding] = [one.task.holding for one in tower.store.tasks("ann", "loft") if one.task.id == trip]
    assert holding == tower.clock()
    for _ in range(SAMPLES):
        tell(place, 3.0)
        place.say(robot_link.ContainerBeat(busy=False, report=StateReport(battery=0.97, docked="docked at dock 'a'")))
        await tower.after()
    tower.journeys.seconds = [[10.0]]
    over(tower, "t", "L1")
    await tower.after()
    assert [topic for topic, _ in delivered(place)] == [UNDOCK_ROBOT.goal.name]
    assert len(tower.journeys.of_robot("ann", "r")) == 1, "it still stands at the dock"
    place.publish_json(UNDOCK_ROBOT.result.name, {"status": status | {"goal_id": {"id": "task-t-0-0"}}})
    place.say(robot_link.ContainerBeat(busy=False, report=StateReport(battery=0.97)))
    await tower.after()
    assert [each.id for each in tower.journeys.of_robot("ann", "r")] == [journey.id, "task-t-0-0"]

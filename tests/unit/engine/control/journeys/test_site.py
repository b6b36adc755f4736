"""Sites: the orders of journeys are obeyed, also when a store, a robot or a plan is not there at once."""

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from engine.control.journeys import site as site_module
from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.site import JourneySite, SiteHooks
from engine.control.views import GoalView
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import Place, layout_of
from ppaas.buildings.lifts.states import LiftRide, LiftState
from ppaas.buildings.riding.floor_maps import part_around
from ppaas.errors import Conflict, NotFound, NoValidPath, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse, FloorPart
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from tests.support.waiting import until

ZONES = ZoneSet(
    [
        Zone(
            Polygon([[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]]), LiftCar(name="car", lift="north")
        ),
        Zone(LineString([[0.5, 2.1], [1.5, 2.1]]), Door(name="landing", lift="north")),
    ]
)
LAYOUT = layout_of(
    Building(
        floors=(Floor(name="L1", map="map-1"), Floor(name="L2", map="map-2", elevation=0.5)),
        lifts=(LiftSettings(lift="north", device="sim:", speed=5.0, doors=0.2),),
    ),
    {"L1": ZONES, "L2": ZONES},
)
GOAL: Place = (5.0, 5.0, 0.0)
WAIT: Place = (1.0, 3.0, -1.5)
JOURNEY = Journey(id="journey-1", user="ann", robot="tb1", building="hotel", floor="L2", goal=GOAL, on="L1")
LEGS = [
    JourneyLeg(kind="drive", floor="L1", to_floor="L1", start=GOAL, goal=WAIT),
    JourneyLeg(kind="lift", floor="L1", to_floor="L2", start=WAIT, goal=WAIT, name="north"),
    JourneyLeg(kind="drive", floor="L2", to_floor="L2", start=WAIT, goal=GOAL),
]


@dataclass
class Robot:
    """Robot that reaches each goal at once, if it is connected."""

    ended: Callable[[GoalView], None] = lambda _: None
    map: str = "map-1"
    pose: Place | None = (5.0, 5.0, 0.0)
    is_here: bool = True
    goals: list[tuple[str, Place]] = field(default_factory=list)
    cancelled: list[str] = field(default_factory=list)
    maps: list[str] = field(default_factory=list)
    left: bool = False
    reaches: bool = True
    asked: list[FindFloorRequest] = field(default_factory=list)
    answers: list[FindFloorResponse | PPaaSError] = field(default_factory=list)
    """Answers to questions for the floor; without one, it is on the floor that it is taken to be on."""

    def send(self, goal_id: str, pose: Place) -> None:
        if not self.is_here:
            raise Unavailable("it is away")
        self.goals.append((goal_id, pose))
        if self.reaches:
            self.pose = pose
            view = GoalView(goal_id, pose, "succeeded", "", 0.0)
            asyncio.get_running_loop().call_soon(self.ended, view)

    def cancel(self, goal_id: str) -> None:
        self.cancelled.append(goal_id)

    async def change_map(self, map_id: str, pose: Place) -> None:
        self.maps.append(map_id)
        self.map, self.pose = map_id, pose

    async def find_floor(self, request: FindFloorRequest) -> FindFloorResponse:
        if not request.floors:
            return FindFloorResponse(pressure=99_000.0)
        self.asked.append(request)
        answer = self.answers.pop(0) if self.answers else FindFloorResponse(request.named, known=True)
        if isinstance(answer, PPaaSError):
            raise answer
        return answer

    def leave(self) -> None:
        self.left = True


@dataclass
class Around:
    """What is around a site: a robot, a store, a planner, and the changes that were heard of."""

    robot: Robot = field(default_factory=Robot)
    kept: list[tuple[list[Journey], list[LiftRide]]] = field(default_factory=list)
    changes: list[Journey] = field(default_factory=list)
    plan_error: Exception | None = None
    store_errors: int = 0

    def rider(self, _journey: Journey, ended: Callable[[GoalView], None]) -> Robot:
        self.robot.ended = ended
        return self.robot

    async def plan(self, journey: Journey, pose: Place) -> list[JourneyLeg]:
        if self.plan_error is not None:
            raise self.plan_error
        return LEGS if journey.on == "L1" else LEGS[2:]

    async def keep(self, journeys: list[Journey], rides: list[LiftRide]) -> None:
        if self.store_errors:
            self.store_errors -= 1
            raise Unavailable("no store")
        self.kept.append((journeys, rides))

    async def parts(self, journey: Journey) -> dict[str, FloorPart]:
        assert (journey.now.name, journey.out) == ("north", journey.on)
        grid = GridMap(np.zeros((40, 40), np.int8), GridInfo(0.1, 40, 40))
        return {name: part_around(grid, Pose2D(1.0, 1.0), name, 0.0) for name in ("L1", "L2")}

    def site(self, kept: KeptJourneys | None = None) -> JourneySite:
        hooks = SiteHooks(self.rider, self.plan, self.keep, self.changes.append, self.parts)
        return JourneySite("ann/hotel", LAYOUT, hooks, DeviceHosts(), kept=kept or KeptJourneys())


@pytest.fixture
def around(monkeypatch: pytest.MonkeyPatch) -> Around:
    monkeypatch.setattr(site_module, "PAUSE", 0.02)
    monkeypatch.setattr(site_module, "TICK", 0.02)
    return Around()


@pytest.fixture
async def running() -> AsyncIterator[Callable[[JourneySite], None]]:
    tasks: list[asyncio.Task[None]] = []
    yield lambda site: tasks.append(asyncio.create_task(site.run()))
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def test_a_robot_is_led_through_a_lift_to_its_goal(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    site = around.site()
    around.store_errors = 2
    site.begin(JOURNEY)
    running(site)
    await until(lambda: site.is_idle, 30.0)
    last = around.changes[-1]
    assert (last.state, last.on) == ("succeeded", "L2")
    assert around.robot.maps == ["map-2"] and around.robot.left
    assert [pose for _, pose in around.robot.goals][-1] == GOAL
    assert len({name for name, _ in around.robot.goals}) == len(around.robot.goals) == 4
    assert any(rides and rides[0].phase == "inside" for _, rides in around.kept) and around.kept[-1] == ([], [])


async def test_a_stored_journey_goes_on_where_the_robot_is(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    inside = Journey(
        id="journey-1", user="ann", robot="tb1", building="hotel", floor="L2", goal=GOAL, on="L1",
        legs=tuple(LEGS), leg=1, phase="inside", sent=2,
    )  # fmt: skip
    ride = LiftRide(robot="ann/tb1", lift="north", origin="L1", destination="L2", phase="inside")
    around.robot.pose = 1.0, 1.0, 1.5
    site = around.site(KeptJourneys((inside,), (ride,)))
    running(site)
    await until(lambda: site.is_idle, 30.0)
    assert around.changes[-1].state == "succeeded" and around.robot.maps == ["map-2"]
    assert [name for name, _ in around.robot.goals] == ["journey-1/3", "journey-1/4"]


async def test_a_robot_that_is_away_gets_its_goal_when_it_is_back(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.robot.is_here = False
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: bool(around.changes) and around.changes[-1].phase == "driving")
    assert around.robot.goals == []
    around.robot.is_here, around.robot.reaches = True, False
    await until(lambda: bool(around.robot.goals))
    assert site.cancel(JOURNEY).state == "canceled"
    await until(lambda: site.is_idle)
    assert around.robot.cancelled == ["journey-1/1"]
    assert site.cancel(JOURNEY) is JOURNEY, "it is not led any more"


async def test_a_journey_ends_when_a_client_sends_the_robot_elsewhere(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.robot.reaches = False
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: bool(around.robot.goals))
    around.robot.ended(GoalView("rest-1", GOAL, "canceled", "", 0.0))
    assert site.journeys, "a goal of another client"
    around.robot.ended(GoalView("journey-1/1", GOAL, "canceled", "This goal was replaced", 0.0))
    await until(lambda: site.is_idle)
    assert around.changes[-1].state == "canceled"


async def test_a_goal_without_a_way_fails_with_the_reason(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.plan_error = NoValidPath("no lift goes there")
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: site.is_idle)
    assert (around.changes[-1].state, around.changes[-1].text) == ("failed", "no lift goes there")


async def test_a_robot_is_planned_again_when_a_lift_on_its_way_breaks(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.robot.reaches = False
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: len(around.robot.goals) == 1 and site.runner.lifts.cars["north"].state is not None)
    site.runner.lifts.lift_state(LiftState(lift="north", floor="L1", mode="offline"), site._clock())
    await until(lambda: len(around.robot.goals) == 2)
    assert around.robot.cancelled == ["journey-1/1"]
    assert around.changes[-1].avoid == ("north",)


async def test_who_looks_sees_the_lift_the_robot_in_it_and_what_has_ended(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    waits: list[float] = []
    hooks = SiteHooks(around.rider, around.plan, around.keep, around.changes.append, around.parts, waited=waits.append)
    site = JourneySite("ann/hotel", LAYOUT, hooks, DeviceHosts(), kept=KeptJourneys())
    running(site)
    seen = await site.view()
    assert [(lift.lift, lift.fault) for lift in seen.devices.lifts] == [("north", "")], "after its first report"
    site.begin(JOURNEY)
    await until(lambda: any(change.phase == "inside" for change in around.changes))
    [journey] = (await site.view()).journeys
    assert (journey.robot, journey.leg, journey.floor, journey.state) == ("tb1", "north", "L2", "active")
    await until(lambda: site.is_idle, 30.0)
    [ended] = (await site.view()).journeys
    assert (ended.state, ended.on, ended.leg) == ("succeeded", "L2", "")
    assert len(waits) == 1 and 0.0 <= waits[0] < 30.0
    assert {(wait.lift, wait.floor) for wait in site.waits} == {("north", "L1"), ("north", "L2")}


async def test_a_clone_is_asked_for_the_floor_until_it_answers(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.robot.answers = [Unavailable("the container was lost"), FindFloorResponse("L2", known=True)]
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: site.is_idle, 30.0)
    assert around.changes[-1].state == "succeeded" and len(around.robot.asked) == 2
    request = around.robot.asked[-1]
    assert (request.origin, request.destination, request.named, request.pressure) == ("L1", "L2", "L2", 99_000.0)
    assert 0.0 < request.seconds < 30.0 and [part.floor for part in request.floors] == ["L1", "L2"]


@pytest.mark.parametrize("error", [NotFound("service", "find_floor"), Conflict("the robot localizes itself")])
async def test_a_clone_that_cannot_compare_scans_believes_the_lift(
    around: Around, running: Callable[[JourneySite], None], error: PPaaSError
) -> None:
    around.robot.answers = [error]
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: site.is_idle, 30.0)
    assert around.changes[-1].state == "succeeded" and len(around.robot.asked) == 1


async def test_a_robot_that_scans_show_on_another_floor_goes_on_from_its_map(
    around: Around, running: Callable[[JourneySite], None]
) -> None:
    around.robot.answers = [FindFloorResponse("L1", known=True, pose=[1.0, 2.5, 1.5])]
    site = around.site()
    site.begin(JOURNEY)
    running(site)
    await until(lambda: site.is_idle, 60.0)
    assert around.robot.maps == ["map-2", "map-1", "map-2"], "back, and once more by the lift"
    assert around.changes[-1].state == "succeeded"
    assert any("it is on floor 'L1', not on 'L2'" in each.text for each in around.changes)

"""Sites: the orders of journeys are obeyed, also when a store, a robot or a plan is not there at once."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import dataclass, field

import pytest

from engine.control.buildings.building_runner import NO_SERVICE
from engine.control.journeys import site as site_module
from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.site import JourneySite, SiteHooks
from engine.control.views import GoalView
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import Place, layout_of
from ppaas.buildings.lifts.states import LiftRide, LiftState
from ppaas.errors import NoValidPath, Unavailable
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

    def leave(self) -> None:
        self.left = True


@dataclass
class Around:
    """What is around a site: a robot, a store, a planner, and the changes that were heard of."""

    robot: Robot = field(default_factory=Robot)
    kept: list[tuple[list[Journey], list[LiftRide]]] = field(default_factory=list)
    changes: list[Journey] = field(default_factory=list)
    waits: list[Mapping[str, float]] = field(default_factory=list)
    plan_error: Exception | None = None
    store_errors: int = 0

    def rider(self, _journey: Journey, ended: Callable[[GoalView], None]) -> Robot:
        self.robot.ended = ended
        return self.robot

    async def plan(self, journey: Journey, pose: Place, waits: Mapping[str, float]) -> list[JourneyLeg]:
        self.waits.append(waits)
        if self.plan_error is not None:
            raise self.plan_error
        return LEGS if journey.on == "L1" else LEGS[2:]

    async def keep(self, journeys: list[Journey], rides: list[LiftRide]) -> None:
        if self.store_errors:
            self.store_errors -= 1
            raise Unavailable("no store")
        self.kept.append((journeys, rides))

    def site(self, kept: KeptJourneys | None = None) -> JourneySite:
        hooks = SiteHooks(self.rider, self.plan, self.keep, self.changes.append)
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
    assert around.waits[0]["north"] <= NO_SERVICE
    site.runner.lifts.lift_state(LiftState(lift="north", floor="L1", mode="offline"), site._clock())
    await until(lambda: len(around.robot.goals) == 2)
    assert around.robot.cancelled == ["journey-1/1"]
    assert around.changes[-1].avoid == ("north",)

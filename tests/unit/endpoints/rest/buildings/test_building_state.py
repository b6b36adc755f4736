"""State of a building over REST: lifts, doors, journeys, and which robots a caller may know."""

import httpx
import pytest

from endpoints.resources.services import Services
from endpoints.rest.buildings.state_schemas import BuildingStateAnswer
from engine.control.buildings.views import BuildingView, DoorView, LiftView, RideView
from engine.control.journeys.views import JourneyView, LiftWait, SiteView
from ppaas.errors import Unavailable
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.storage.records import robot
from tests.unit.endpoints.conftest import LogIn, Publish
from tests.unit.endpoints.rest.buildings.test_building_plans import GOAL, START, put_two_floors

RIDES = [RideView("ann/tb1", "L1", "L2", "inside", 100.0), RideView("bob/tb2", "L2", "L1", "waiting", 101.0)]
STATE = SiteView(
    BuildingView(
        [LiftView("north", "", "L1", "L2", "closed", "up", "agv", "ppaas/ann/hq/north", RIDES)],
        [DoorView("L1", "gate", "offline", ["bob/tb2"], "door 'gate' of floor 'L1' is offline")],
        ["lift 'south': no plug-in"],
    ),
    [JourneyView("journey-1", "bob", "tb2", "L2", "L1", "waiting", "north", "active", "lift is called", 101.0)],
)
PATH = "/v1/buildings/{}/state"


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    return await put_two_floors(client, log_in, publish)


@pytest.fixture
def journeys(services: Services) -> FakeJourneys:
    services.journeys = made = FakeJourneys()
    made.state = STATE
    return made


async def test_the_owner_of_a_building_sees_lifts_doors_journeys_and_all_robots(
    client: httpx.AsyncClient, ann: dict[str, str], journeys: FakeJourneys
) -> None:
    answer = await client.get(PATH.format("hq"), headers=ann)
    assert answer.status_code == 200, answer.text
    found = answer.json()
    BuildingStateAnswer.model_validate(found, strict=True)
    [lift], [door], [journey] = found["lifts"], found["doors"], found["journeys"]
    assert (lift["lift"], lift["floor"], lift["target"], lift["door"], lift["fault"]) == (
        "north", "L1", "L2", "closed", "",
    )  # fmt: skip
    assert [(ride["robot"], ride["phase"]) for ride in lift["rides"]] == [("tb1", "inside"), ("bob:tb2", "waiting")]
    assert (door["mode"], door["robots"]) == ("offline", ["bob:tb2"])
    assert (journey["robot"], journey["goal"], journey["leg"]) == ("bob:tb2", "journey-1", "north")
    assert found["faults"] == ["lift 'south': no plug-in"]


async def test_a_reader_sees_own_robots_and_that_there_are_others(
    client: httpx.AsyncClient, ann: dict[str, str], journeys: FakeJourneys, log_in: LogIn, services: Services
) -> None:
    bob = await log_in("bob")
    assert (await client.get(PATH.format("ann:hq"), headers=bob)).status_code == 404
    services.store.put_robot(robot("tb2", user="bob"))
    await client.patch("/v1/buildings/hq", headers=ann, json={"readers": ["bob"]})
    found = (await client.get(PATH.format("ann:hq"), headers=bob)).json()
    assert [ride["robot"] for ride in found["lifts"][0]["rides"]] == [None, "tb2"]
    carol = await log_in("carol")
    await client.patch("/v1/buildings/hq", headers=ann, json={"readers": ["carol"]})
    seen = (await client.get(PATH.format("ann:hq"), headers=carol)).json()
    [journey] = seen["journeys"]
    assert (journey["robot"], journey["goal"], journey["text"]) == (None, None, "")
    assert seen["doors"][0]["robots"] == [None]


async def test_plans_take_the_waits_of_now_and_the_mean_ones_if_the_master_is_silent(
    client: httpx.AsyncClient, ann: dict[str, str], journeys: FakeJourneys, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def seconds() -> float:
        answer = await client.post("/v1/buildings/hq/plans", headers=ann, json={"start": START, "goal": GOAL})
        assert answer.status_code == 200, answer.text
        found: float = answer.json()["seconds"]
        return found

    mean = await seconds()
    journeys.waits = [LiftWait("north", "L1", 200.0), LiftWait("north", "L2", 5.0)]
    assert await seconds() == pytest.approx(mean - 30.0 + 200.0)
    journeys.waits = [LiftWait("north", "L1", float("inf"))]
    refused = await client.post("/v1/buildings/hq/plans", headers=ann, json={"start": START, "goal": GOAL})
    assert refused.status_code == 422
    assert "lifts that do not serve robots now: north" in refused.json()["detail"]

    async def silent(owner: str, building: str) -> list[LiftWait]:
        raise Unavailable("no master")

    monkeypatch.setattr(journeys, "lift_waits", silent)
    assert await seconds() == mean


async def test_without_a_master_there_is_no_state(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    answer = await client.get(PATH.format("hq"), headers=ann)
    assert (answer.status_code, answer.json()["detail"]) == (
        503, "no master leads lifts and doors for this endpoint",
    )  # fmt: skip

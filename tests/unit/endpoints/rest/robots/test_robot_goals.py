"""Pose and goals of robots over REST."""

import httpx
import msgspec
import pytest

from endpoints.resources.services import Services
from engine.control import robot_navigation
from engine.master.places import robot_key
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.still_place import StillRobot
from tests.support.storage import records
from tests.unit.endpoints.conftest import LogIn

PATH = "/v1/robots/tb1"


@pytest.fixture
async def ann(log_in: LogIn, services: Services, cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Return the headers of a user with one robot."""
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    headers = await log_in("ann")
    services.store.put_robot(records.robot("tb1", user="ann"))
    return headers


@pytest.fixture
def place(cloud: FakeCloud) -> StillRobot:
    """Return the place of the robot, which is connected."""
    key = robot_key("ann", "tb1")
    made = cloud.places[key] = StillRobot()
    made.container = "c1"
    cloud.presence.came(key)
    return made


async def test_a_goal_is_sent_shown_listed_and_cancelled(
    client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot, cloud: FakeCloud
) -> None:
    sent = await client.post(f"{PATH}/goals", headers=ann, json={"pose": [4.0, 1.5]})
    assert sent.status_code == 201
    goal = sent.json()
    assert (goal["state"], goal["pose"], goal["ended"]) == ("pending", [4.0, 1.5, 0.0], None)
    assert (await client.get(f"{PATH}/goals/{goal['id']}", headers=ann)).json() == goal
    assert (await client.get(f"{PATH}/goals", headers=ann)).json() == {"items": [goal], "next": None}
    state = (await client.get(f"{PATH}/state", headers=ann)).json()
    here = {"connected": True, "disconnected_since": None, "container": True}
    assert state == here | {"pose": None, "pose_at": None, "localization": "", "goals": [goal]}
    assert (await client.delete(f"{PATH}/goals/{goal['id']}", headers=ann)).status_code == 202
    assert (await client.delete(f"{PATH}/goals", headers=ann)).status_code == 202
    cloud.robots.close()


async def test_goals_are_listed_in_pages(client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot) -> None:
    for x in range(3):
        await client.post(f"{PATH}/goals", headers=ann, json={"pose": [x, 0.0, 0.0]})
    first = (await client.get(f"{PATH}/goals", headers=ann, params={"limit": 2})).json()
    rest = (await client.get(f"{PATH}/goals", headers=ann, params={"cursor": first["next"]})).json()
    assert [goal["pose"][0] for goal in first["items"] + rest["items"]] == [0.0, 1.0, 2.0]


async def test_a_robot_that_is_not_connected_takes_no_goal(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    problem_of(await client.post(f"{PATH}/goals", headers=ann, json={"pose": [1.0, 2.0]}), 503, "unavailable")
    problem_of(await client.delete(f"{PATH}/goals", headers=ann), 503, "unavailable")
    assert (await client.get(f"{PATH}/state", headers=ann)).json()["connected"] is False


async def test_a_robot_that_left_is_not_connected_while_its_container_waits(
    client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot, cloud: FakeCloud
) -> None:
    assert (await client.get("/v1/robots", headers=ann)).json()["items"][0]["connected"] is True
    cloud.presence.left(robot_key("ann", "tb1"))
    state = (await client.get(f"{PATH}/state", headers=ann)).json()
    assert (state["connected"], state["container"]) == (False, True)
    assert state["disconnected_since"] is not None
    assert (await client.get("/v1/robots", headers=ann)).json()["items"][0]["connected"] is False
    problem_of(await client.post(f"{PATH}/goals", headers=ann, json={"pose": [1.0, 2.0]}), 503, "unavailable")


async def test_robots_of_others_and_unknown_goals_are_not_found(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn, place: StillRobot
) -> None:
    bob = await log_in("bob")
    for method, path in (("GET", "/state"), ("GET", "/goals"), ("DELETE", "/goals"), ("GET", "/goals/rest-1")):
        problem_of(await client.request(method, PATH + path, headers=bob), 404, "not-found")
    problem_of(await client.post(f"{PATH}/goals", headers=bob, json={"pose": [1.0, 2.0]}), 404, "not-found")
    for method in ("GET", "DELETE"):
        problem_of(await client.request(method, f"{PATH}/goals/rest-1", headers=ann), 404, "not-found")


@pytest.mark.parametrize("body", [{}, {"pose": [1.0]}, {"pose": [1.0, "x"]}, {"pose": [1, 2, 3, 4]}, {"x": 1}, []])
async def test_an_invalid_goal_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot, body: object
) -> None:
    problem_of(await client.post(f"{PATH}/goals", headers=ann, json=body), 422, "invalid-request")


async def test_a_goal_on_a_floor_is_a_journey(
    client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot, services: Services, cloud: FakeCloud
) -> None:
    body = {"pose": [4.0, 1.5], "floor": "L2"}
    problem_of(await client.post(f"{PATH}/goals", headers=ann, json=body), 503, "unavailable")
    services.journeys = led = FakeJourneys()
    other = (await client.post(f"{PATH}/goals", headers=ann, json={"pose": [1.0, 1.0]})).json()
    sent = await client.post(f"{PATH}/goals", headers=ann, json=body)
    assert (sent.status_code, sent.json()["id"], led.asked) == (201, "journey-1", [("ann", "tb1", "L2")])
    listed = (await client.get(f"{PATH}/goals", headers=ann)).json()["items"]
    assert [goal["id"] for goal in listed] == ["journey-1", other["id"]]
    assert (await client.get(f"{PATH}/goals/journey-1", headers=ann)).json() == sent.json()
    assert (await client.delete(f"{PATH}/goals/journey-1", headers=ann)).json()["state"] == "canceled"
    led.sent = [msgspec.structs.replace(led.sent[0], id="task-t-0-0", state="active", ended=None)]
    assert (await client.get(f"{PATH}/goals/task-t-0-0", headers=ann)).json()["state"] == "active"
    assert (await client.delete(f"{PATH}/goals/task-t-0-0", headers=ann)).json()["state"] == "canceled"
    for method in ("GET", "DELETE"):
        problem_of(await client.request(method, f"{PATH}/goals/journey-9", headers=ann), 404, "not-found")
    problem_of(await client.post(f"{PATH}/goals", headers=ann, json=body | {"floor": "roof"}), 422, "invalid-building")
    cloud.robots.close()


async def test_all_goals_are_cancelled_with_those_on_floors(
    client: httpx.AsyncClient, ann: dict[str, str], place: StillRobot, services: Services, cloud: FakeCloud
) -> None:
    services.journeys = led = FakeJourneys()
    await client.post(f"{PATH}/goals", headers=ann, json={"pose": [4.0, 1.5], "floor": "L2"})
    assert (await client.delete(f"{PATH}/goals", headers=ann)).status_code == 202
    assert led.sent[0].state == "canceled"
    await client.post(f"{PATH}/goals", headers=ann, json={"pose": [4.0, 1.5], "floor": "L2"})
    await client.post(f"{PATH}/goals", headers=ann, json={"pose": [1.0, 1.0]})
    assert led.sent[0].state == "canceled", "another goal replaces it"
    cloud.robots.close()

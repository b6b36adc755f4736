"""Plans of fleets over REST."""

import httpx
import pytest

from endpoints.rest.plans import fleet_plans
from ppaas.errors import StartOccupied
from ppaas.nodes.planner_server import fleet_service
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

REQUEST = {"starts": [[0, 0], [1, 2, 0.5]], "goals": [[3, 4], [1, 1]], "radius": 0.2}
URL = "/v1/maps/house/fleet_plans"


@pytest.fixture
async def headers(publish: Publish, log_in: LogIn) -> dict[str, str]:
    """Return the header of ann, who has a map."""
    ann = await log_in("ann")
    assert (await publish(ann)).status_code == 201
    return ann


async def test_paths_are_returned_with_map_and_container(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    answer = await client.post(URL, headers=headers, json=REQUEST)
    assert answer.status_code == 200, answer.text
    plan = answer.json()
    assert plan["paths"] == [[[0.0, 0.0]], [[1.0, 2.0]]]
    assert (plan["times"], plan["turns"]) == ([[0.0], [0.0]], 0)
    assert {name: plan[name] for name in ("spacing", "step_seconds", "cost", "bound", "makespan", "seconds")} == {
        "spacing": 0.5, "step_seconds": 1.0, "cost": 0, "bound": 0, "makespan": 0, "seconds": 0.001,
    }  # fmt: skip
    assert (plan["map"], plan["container"], plan["pid"]) == ("house", "c9", 4711)
    [(user, version, request)] = cloud.fleets_asked
    assert (user, version.id, version.version) == ("ann", "house", plan["version"])
    assert request.starts == ((0.0, 0.0), (1.0, 2.0, 0.5))
    assert (request.radius, request.margin, request.speed, request.seconds, request.seed) == (0.2, 0.05, 0.5, 0.0, 0)


async def test_all_fields_reach_the_planner(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    more = {"margin": 0.1, "speed": 1.5, "turn_seconds": 1.2, "seconds": 2, "seed": 7, "timeout": 20}
    more |= {"labels": {"zone": "hall-2"}}
    answer = await client.post(URL, headers=headers, json=REQUEST | more)
    assert answer.status_code == 200, answer.text
    request = cloud.fleets_asked[0][2]
    assert {name: getattr(request, name) for name in more} == more
    assert request.speeds is None


async def test_each_robot_may_have_a_speed_of_its_own(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    answer = await client.post(URL, headers=headers, json=REQUEST | {"speeds": [0.5, 1.25]})
    assert answer.status_code == 200, answer.text
    assert cloud.fleets_asked[0][2].speeds == (0.5, 1.25)


async def test_the_error_of_a_speed_names_the_robot(client: httpx.AsyncClient, headers: dict[str, str]) -> None:
    answer = await client.post(URL, headers=headers, json=REQUEST | {"speeds": [0.5, 0.0001]})
    [fault] = problem_of(answer, 422, "invalid-request")["errors"]
    assert fault["where"] == ["body", "speeds", "1"]


@pytest.mark.parametrize(
    "change",
    [
        {"starts": [[0]]},
        {"goals": [[0, 0]] * 2001},
        {"radius": 0},
        {"radius": "wide"},
        {"margin": -1},
        {"speed": 0},
        {"speed": 5e-324},
        {"speeds": [0.5]},
        {"speeds": []},
        {"speeds": [0.5, 0]},
        {"speeds": [0.5, 0.5], "speed": 0.5},
        {"turn_seconds": -0.1},
        {"turn_seconds": 1001},
        {"seconds": 10.1},
        {"seed": 1.5},
        {"seed": -1},
        {"seed": 1 << 31},
        {"timeout": 1e6},
        {"timeout": 0},
        {"planner": "astar"},
    ],
)
async def test_invalid_requests_are_refused(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud, change: dict[str, object]
) -> None:
    answer = await client.post(URL, headers=headers, json=REQUEST | change)
    assert answer.status_code == 422, answer.text
    assert cloud.fleets_asked == []


async def test_the_radius_is_required(client: httpx.AsyncClient, headers: dict[str, str]) -> None:
    answer = await client.post(URL, headers=headers, json={"starts": [], "goals": []})
    [fault] = problem_of(answer, 422, "invalid-request")["errors"]
    assert fault["where"] == ["body", "radius"]


async def test_as_many_robots_as_allowed_are_read(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    places = [[number, 0.5] for number in range(fleet_plans.MAX_ROBOTS)]
    answer = await client.post(URL, headers=headers, json=REQUEST | {"starts": places, "goals": places})
    assert answer.status_code == 200, answer.text
    assert len(cloud.fleets_asked[0][2].starts) == fleet_plans.MAX_ROBOTS


async def test_planner_errors_are_returned_with_their_code(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.error = StartOccupied("the start of robot 3 is occupied")
    answer = await client.post(URL, headers=headers, json=REQUEST)
    assert (answer.status_code, answer.json()["code"]) == (422, 205)


async def test_a_map_without_read_access_is_not_found(
    client: httpx.AsyncClient, headers: dict[str, str], log_in: LogIn
) -> None:
    answer = await client.post(URL, headers=await log_in("bob"), json=REQUEST)
    assert answer.status_code == 404


def test_route_and_container_have_the_same_limits() -> None:
    assert fleet_plans.MAX_ROBOTS == fleet_service.MAX_ROBOTS
    assert fleet_plans.LEAST_SPEED == fleet_service.LEAST_SPEED
    assert fleet_plans.MAX_SECONDS == fleet_service.MAX_SECONDS
    assert fleet_plans.MAX_TURN == fleet_service.MAX_TURN

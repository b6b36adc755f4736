"""Homes of a robot's nodes over REST."""

import httpx
import pytest

from ppaas.errors import NotFound, PPaaSError, Unavailable
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

NODES = "/v1/robots/tb1/nodes"


async def put_robot(client: httpx.AsyncClient, ann: dict[str, str], publish: Publish) -> None:
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})


async def test_each_node_is_listed_with_its_home_and_reasons(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    page = (await client.get(NODES, headers=ann, params={"limit": 1})).json()
    assert [node["node"] for node in page["items"]] == ["amcl"]
    rest = (await client.get(NODES, headers=ann, params={"cursor": page["next"]})).json()
    assert rest == {
        "items": [
            {"node": "move_base", "home": "robot", "wanted": "robot", "score": -0.5, "reasons": ["it is near"]}
        ],
        "next": None,
    }  # fmt: skip


@pytest.mark.parametrize(("asked", "wanted"), [({}, "cloud"), ({"home": None}, "cloud"), ({"home": "robot"}, "robot")])
async def test_requesting_a_home_returns_where_the_node_will_run(
    asked: dict[str, str], wanted: str, client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    answer = await client.post(f"{NODES}/move_base", headers=ann, json=asked)
    assert (answer.status_code, answer.json()["wanted"]) == (200, wanted)


async def test_an_invalid_home_is_refused(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    for body in ({"home": "moon"}, {"home": 1}, {"house": "cloud"}, []):
        problem_of(await client.post(f"{NODES}/move_base", headers=ann, json=body), 422, "invalid-request")


@pytest.mark.parametrize(
    ("error", "status", "slug"),
    [(Unavailable("no container now"), 503, "unavailable"), (NotFound("node", "move_base"), 404, "not-found")],
)
async def test_an_unreachable_robot_or_unknown_node_is_reported(
    error: PPaaSError, status: int, slug: str,
    client: httpx.AsyncClient, cloud: FakeCloud, log_in: LogIn, publish: Publish,
) -> None:  # fmt: skip
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    cloud.error = error
    problem_of(await client.get(NODES, headers=ann), status, slug)
    problem_of(await client.post(f"{NODES}/move_base", headers=ann, json={}), status, slug)


async def test_nodes_of_other_users_robots_are_not_found(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await put_robot(client, ann, publish)
    problem_of(await client.get(NODES, headers=bob), 404, "not-found")
    problem_of(await client.post(f"{NODES}/move_base", headers=bob, json={}), 404, "not-found")

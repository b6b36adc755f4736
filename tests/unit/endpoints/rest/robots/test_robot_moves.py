"""Robots that are brought to other maps, over REST."""

import httpx
import msgspec
import pytest

from endpoints.resources.services import Services
from ppaas.errors import Unavailable
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.storage import records
from tests.unit.endpoints.conftest import LogIn

MOVE = "/v1/robots/tb1/move"
UP = {"map": "house-2", "pose": [4.0, 2.0, 0.5]}


@pytest.fixture
async def ann(log_in: LogIn, services: Services) -> dict[str, str]:
    """Return the headers of a user with a robot and two maps."""
    headers = await log_in("ann")
    services.store.put_robot(records.robot("tb1", user="ann", map="house"))
    for name in ("house", "house-2"):
        records.put_map(services.map_store, records.house(name))
    return headers


async def test_map_and_pose_in_the_file_change_and_the_master_is_notified(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    before = services.store.robot("ann", "tb1")
    answer = await client.post(MOVE, headers=ann, json=UP)
    assert answer.status_code == 200
    assert (answer.json()["map"], answer.json()["initial_pose"]) == ("house-2", [4.0, 2.0, 0.5])
    after = services.store.robot("ann", "tb1")
    assert after == msgspec.structs.replace(before, map="house-2", initial_pose=(4.0, 2.0, 0.5))
    assert cloud.moved == [("ann", "tb1")]


async def test_a_move_is_stored_although_no_master_answers(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    cloud.error = Unavailable("no master")
    problem_of(await client.post(MOVE, headers=ann, json=UP), 503, "unavailable")
    assert services.store.robot("ann", "tb1").map == "house-2", "it goes on there once a master answers"


async def test_what_cannot_be_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn, services: Services, cloud: FakeCloud
) -> None:
    records.put_map(services.map_store, records.house("bobs", owner="bob"))
    for name in ("bobs", "nowhere"):
        problem_of(await client.post(MOVE, headers=ann, json=UP | {"map": name}), 404, "not-found")
    problem_of(await client.post(MOVE, headers=await log_in("bob"), json=UP), 404, "not-found")
    masked = records.robot("tb2", user="ann", map="house", parameters={"keepout_filter": {"filter_mask": "house-2"}})
    services.store.put_robot(masked)
    path = "/v1/robots/tb2/move"
    told = problem_of(await client.post(path, headers=ann, json=UP), 422, "invalid-parameter")
    assert "keepout_filter" in str(told)
    assert (await client.post(path, headers=ann, json=UP | {"map": "house"})).status_code == 200
    services.store.put_robot(records.robot("tb3", user="ann", map="new:attic"))
    problem_of(await client.post("/v1/robots/tb3/move", headers=ann, json=UP), 422, "invalid-parameter")
    assert cloud.moved == [("ann", "tb2")]

"""Traffic of a map over REST: what robots hold, and robots that are taken out and put back."""

import httpx
import pytest

from endpoints.resources.services import Services
from ppaas.errors import NotFound
from ppaas.traffic.taking_part import traffic_checkpoint
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.traffic import add_traffic
from tests.support.storage.records import clone
from tests.unit.endpoints.conftest import LogIn, Publish

TRAFFIC = "/v1/maps/house/traffic"


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish, cloud: FakeCloud) -> dict[str, str]:
    """Return the header of a user who has published a map for all, and has two robots in its traffic."""
    header = await log_in("ann")
    await publish(header, readers="*")
    add_traffic(cloud, "ann", "house")
    return header


async def test_traffic_is_shown_with_what_each_robot_holds_and_waits_for(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    answer = (await client.get(TRAFFIC, headers=ann)).json()
    assert (answer["map"], answer["at"], answer["spacing"], answer["goals"]) == ("house", 100.5, 0.5, 12)
    waiting, idle = answer["robots"]
    assert (waiting["robot"], waiting["state"], waiting["pose"]) == ("tb1", "waiting", [1.0, 2.0, 0.5])
    assert (waiting["way"], waiting["waits_for"]) == ([[1.0, 2.0], [1.5, 2.0]], "tb2")
    assert (waiting["goal_id"], waiting["goal"], waiting["waited"]) == ("g1", [4.0, 2.0], 3.5)
    assert (idle["state"], idle["goal_id"], idle["goal"]) == ("idle", "", None)


async def test_robots_are_taken_out_and_put_back(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    assert (await client.post(f"{TRAFFIC}/robots/tb1/take_out", headers=ann)).status_code == 204
    assert cloud.taken_out == {("ann", "house", "tb1")}
    assert (await client.post(f"{TRAFFIC}/robots/tb1/put_back", headers=ann)).status_code == 204
    assert cloud.taken_out == set()
    for change in ("take_out", "put_back"):
        unknown = await client.post(f"{TRAFFIC}/robots/tb9/{change}", headers=ann)
        assert "tb1" in problem_of(unknown, 404, "not-found")["detail"], "the known ones are listed"
        invalid = await client.post(f"{TRAFFIC}/robots/..tb1/{change}", headers=ann)
        problem_of(invalid, 422, "invalid-request")


@pytest.mark.parametrize("user", ["bob", "admin"])
async def test_traffic_of_other_users_robots_is_neither_shown_nor_changed(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str], cloud: FakeCloud, user: str
) -> None:
    other = await log_in(user)
    missing = problem_of(await client.get(TRAFFIC, headers=other), 503, "unavailable")
    assert f"no robot of user '{user}' takes part" in missing["detail"]
    problem_of(await client.post(f"{TRAFFIC}/robots/tb1/take_out", headers=other), 503, "unavailable")
    assert cloud.taken_out == set() and ann


async def test_a_map_that_may_not_be_read_is_unknown(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    await publish(await log_in("ann"))
    bob = await log_in("bob")
    problem_of(await client.get(TRAFFIC, headers=bob), 404, "not-found")
    for change in ("take_out", "put_back"):
        problem_of(await client.post(f"{TRAFFIC}/robots/tb1/{change}", headers=bob), 404, "not-found")


async def test_checkpoints_of_traffic_nodes_go_with_their_map(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    services.store.save_clone(clone(traffic_checkpoint("house"), user="ann"))
    assert (await client.delete("/v1/maps/house", headers=ann)).status_code == 204
    assert cloud.maps_without_groups == ["house"]
    with pytest.raises(NotFound):
        services.store.clone("ann", traffic_checkpoint("house"))

"""Diagnosis of a robot over REST."""

import httpx
import msgspec
import pytest

from endpoints.resources.services import Services
from engine.master.places import robot_key
from engine.master.quotas import Quota
from ppaas.diagnosis.observations.facts import FrameFacts, LinkFacts
from ppaas.errors import Conflict
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.world.diagnosed_robot import LINK, healthy
from tests.unit.endpoints.conftest import LogIn, Publish

DIAGNOSIS = "/v1/robots/tb1/diagnosis"


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Return the headers of the owner of robot tb1."""
    headers = await log_in("ann")
    await publish(headers)
    await client.put("/v1/robots/tb1", headers=headers, json={"map": "house"})
    return headers


def kinds(diagnosis: dict[str, list[dict[str, str]]]) -> list[str]:
    return [finding["kind"] for finding in diagnosis["findings"]]


async def test_findings_topics_and_frames_of_a_connected_robot(
    client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    link = msgspec.structs.replace(LINK, subscribed=())
    cloud.presence.came(robot_key("ann", "tb1"))
    cloud.observations = healthy(link=link, frames=[FrameFacts(name="laser", parents=("base_link",), static=True)])
    answer = await client.get(DIAGNOSIS, headers=ann, params={"seconds": 1.5})
    said = answer.json()
    assert (answer.status_code, said["robot"], said["connected"], said["level"]) == (200, "tb1", True, "error")
    assert kinds(said)[0] == "cmd-vel-unheard"
    assert said["findings"][0]["advice"].startswith("Subscribe to 'cmd_vel'")
    assert [topic["name"] for topic in said["topics"]] == ["scan", "odom"]
    assert said["topics"][0]["rate"] == 10.0
    assert said["frames"] == [{"name": "laser", "parent": "base_link", "static": True, "silence": 0.0}]
    assert cloud.observed == [("ann", "tb1", 1.5)]


async def test_robot_without_a_container_is_told_what_would_stop_it(
    client: httpx.AsyncClient, services: Services, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    said = (await client.get(DIAGNOSIS, headers=ann)).json()
    assert (said["connected"], kinds(said), said["topics"]) == (False, ["robot-not-connected"], [])
    with pytest.raises(Conflict), services.refused_connects.attempt("ann", "tb1", "robot"):
        raise Conflict("the robot is connected already")
    services.map_store.remove_map("house")
    services.map_cache.forget("house")
    cloud.known.clear()
    cloud.quotas._default = Quota(containers=0)
    said = (await client.get(DIAGNOSIS, headers=ann)).json()
    assert kinds(said) == ["connect-refused", "map-unusable", "quota", "no-machine", "robot-not-connected"]


async def test_clone_that_does_not_answer_is_no_robot_that_is_not_connected(
    client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    cloud.running = [container("c1")]
    cloud.presence.came(robot_key("ann", "tb1"))
    said = (await client.get(DIAGNOSIS, headers=ann)).json()
    assert (said["connected"], kinds(said)) == (True, ["clone-not-ready"])


async def test_place_with_operators_only_has_no_robot(
    client: httpx.AsyncClient, cloud: FakeCloud, ann: dict[str, str]
) -> None:
    cloud.observations = healthy(link=LinkFacts(operators=1))
    said = (await client.get(DIAGNOSIS, headers=ann)).json()
    assert (said["connected"], kinds(said)) == (False, ["robot-not-connected"])


async def test_unknown_robots_and_times_out_of_range_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str]
) -> None:
    problem_of(await client.get("/v1/robots/tb9/diagnosis", headers=ann), 404, "not-found")
    problem_of(await client.get(DIAGNOSIS, headers=await log_in("bob")), 404, "not-found")
    for seconds in ("9", "-1", "nan", "x"):
        problem_of(await client.get(DIAGNOSIS, headers=ann, params={"seconds": seconds}), 422, "invalid-request")

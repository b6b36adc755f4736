"""Paths are reused between users and robots of the same map version only."""

import json
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest
from websockets.asyncio.client import connect

from benchmarks.harness.plan_calls import compute_path_call
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, NotFound, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import OCCUPIED, GridMap
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.plans.history import MOST_BUCKETS, computed_row
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from storage.sqlite.store import SqliteStore
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

PASSWORD = "correct horse battery"
MINUTE = 60.0


def as_if_planning_took_a_minute(cloud: RunningCloud, map_id: str, version: str) -> None:
    """Write a history in which a search for a stored path always pays, however busy the test machine is."""
    store = SqliteStore(cloud.log.parent / "data" / "ppaas.sqlite")
    try:
        for bucket in range(MOST_BUCKETS):
            store.add_history([computed_row((map_id, version, Dijkstra.name, bucket), MINUTE)] * 64)
    finally:
        store.close()


async def log_in_as_new_user(cloud: RunningCloud) -> RestClient:
    name = f"user-{uuid.uuid4().hex[:8]}"
    await (await cloud.admin()).post("/v1/users", {"id": name, "password": PASSWORD})
    rest = RestClient(cloud.url)
    await rest.login(name, PASSWORD)
    return rest


async def publish(cloud: RunningCloud, rest: RestClient, map_id: str, grid: GridMap) -> str:
    """Publish a map for everybody; return its version."""
    yaml, image = save_map(grid, f"{map_id}.pgm")
    await rest.upload_map(map_id, yaml, image, readers=("*",))
    version = str((await rest.get(f"/v1/maps/{map_id}"))["version"])
    as_if_planning_took_a_minute(cloud, map_id, version)
    return version


@asynccontextmanager
async def robot_of(cloud: RunningCloud, rest: RestClient, map_id: str, start: Pose2D) -> AsyncIterator[str]:
    """Register a robot; yield the URL for its operators."""
    robot = f"robot-{uuid.uuid4().hex[:8]}"
    await rest.put_robot(robot, RobotFile(map=map_id, initial_pose=start, cores=0.5))
    yield f"{cloud.ws_url}/?robot={robot}&role=operator&token={rest.token}"


async def test_a_path_is_reused_by_programs_and_robots_of_other_users(cloud: RunningCloud, office_map: GridMap) -> None:
    ann, bob = await log_in_as_new_user(cloud), await log_in_as_new_user(cloud)
    await publish(cloud, ann, "shared-office", office_map)
    start = free_pose(office_map, seed=40)
    goal = reachable_pose(office_map, start, seed=41, at_least=5.0)
    first = await ann.plan("shared-office", start, goal)
    assert (first["origin"], first["reused"]) == ("computed", None)
    assert (await ann.get(f"/v1/plans/{first['plan_id']}"))["poses"] == first["poses"]
    second = await bob.plan("shared-office", start, goal)
    assert (second["origin"], second["reused"], second["plan_id"]) == ("reused", first["plan_id"], first["plan_id"])
    assert second["poses"] == first["poses"]
    assert (await bob.plan("shared-office", start, goal, reuse=False))["origin"] == "computed"
    assert len(await bob.items("/v1/maps/shared-office/plans")) == 1, "the same path is kept once"
    beside = start._replace(x=start.x + 0.06, y=start.y - 0.04)
    third = await bob.plan("shared-office", beside, goal)
    assert (third["origin"], third["reused"]) == ("reused", first["plan_id"])
    assert third["poses"][0][:2] == pytest.approx(beside[:2])
    along = [(x, y, 0.0) for x, y, *_ in (first["poses"][len(first["poses"]) * part // 8] for part in (1, 7))]
    fourth = await bob.plan("shared-office", *along)
    assert fourth["origin"] == "stitched"
    assert fourth["cost"] < first["cost"]
    async with robot_of(cloud, bob, "shared-office", start) as url, connect(url, max_size=None) as socket:
        await socket.send(compute_path_call(tuple(start), tuple(goal)))
        answer = json.loads(await socket.recv())["values"]
    assert (answer["origin"], answer["reused"]) == ("reused", first["plan_id"])


async def test_a_path_on_another_map_version_is_computed(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await log_in_as_new_user(cloud)
    await publish(cloud, rest, "rebuilt-office", office_map)
    start = free_pose(office_map, seed=42)
    goal = reachable_pose(office_map, start, seed=43, at_least=5.0)
    before = await rest.plan("rebuilt-office", start, goal)
    data = office_map.data.copy()
    data[0, 0] = OCCUPIED if data[0, 0] != OCCUPIED else 0
    await publish(cloud, rest, "rebuilt-office", replace(office_map, data=data))
    after = await rest.plan("rebuilt-office", start, goal)
    assert (after["origin"], after["reused"]) == ("computed", None)
    assert after["version"] != before["version"]
    assert after["plan_id"] != before["plan_id"]


async def test_a_robot_drives_a_stored_path_and_reports_its_reuse(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish(cloud, rest, "driven-office", office_map)
    start = free_pose(office_map, seed=44)
    goal = reachable_pose(office_map, start, seed=45, at_least=2.5, at_most=4.0)
    await rest.plan("driven-office", start, goal)
    token = rest.token
    assert token is not None
    await rest.put_robot("reuser", RobotFile(map="driven-office", initial_pose=start, cores=0.5))
    async with driving(cloud.ws_url, token, "reuser", office_map, start) as drive:
        await drive.send(goal)
        result = await drive.result()
    assert result.status.text.startswith("Goal reached. Plans: ")
    assert "reused" in result.status.text or "stitched" in result.status.text
    evaluated = await rest.get("/v1/maps/driven-office/evaluation")
    (dijkstra,) = evaluated["planners"]
    assert dijkstra["computed"] >= 1


async def test_planner_evaluation_requires_read_access_to_the_map(cloud: RunningCloud, office_map: GridMap) -> None:
    ann, bob = await log_in_as_new_user(cloud), await log_in_as_new_user(cloud)
    yaml, image = save_map(office_map, "private.pgm")
    await ann.upload_map("private-office", yaml, image)
    assert (await ann.get("/v1/maps/private-office/evaluation"))["planners"] == []
    with pytest.raises(NotFound):
        await bob.get("/v1/maps/private-office/evaluation")


async def test_a_path_is_planned_in_another_process_than_the_web_server(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=20)
    goal = reachable_pose(office_map, start, seed=21, at_least=4.0)
    plan = await rest.plan("office", start, goal)
    assert plan["pid"] != cloud.pid
    assert plan["pid"] in {child.pid for child in cloud.children()}
    assert plan["length"] >= start.distance_to(goal)
    assert plan["container"] in {c["id"] for c in await rest.items("/v1/containers") if c["kind"] == "planning"}
    again = await rest.plan("office", start, goal)
    assert again["pid"] == plan["pid"], "the same container plans again"


async def test_parameters_of_a_request_change_the_path_and_its_id(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=20)
    goal = reachable_pose(office_map, start, seed=21, at_least=4.0)
    usual = await rest.plan("office", start, goal)
    wide = await rest.plan("office", start, goal, parameters={"inflation_radius": 2.0, "cost_scaling_factor": 1.0})
    assert wide["plan_id"] != usual["plan_id"]
    assert wide["cost"] > usual["cost"]
    assert wide["conditions"]["global_costmap"] == {"inflation_radius": 2.0, "cost_scaling_factor": 1.0}
    with pytest.raises(InvalidInput, match="no parameter 'speed'; known: allow_unknown"):
        await rest.plan("office", start, goal, parameters={"speed": 1})


async def test_planning_errors_are_raised_by_their_type(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=22)
    wall = next(iter(office_map.info.to_world(list(zip(*(office_map.data == OCCUPIED).nonzero(), strict=True)))))
    with pytest.raises(GoalOccupied):
        await rest.plan("office", start, (*map(float, wall), 0.0))
    with pytest.raises(GoalOutsideMap):
        await rest.plan("office", start, (1e6, 0.0, 0.0))
    with pytest.raises(NotFound, match="atlantis"):
        await rest.plan("atlantis", start, start)
    with pytest.raises(PPaaSError, match="dijkstra"):
        await rest.plan("office", start, start, planner="oracle")

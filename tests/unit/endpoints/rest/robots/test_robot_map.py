"""Maps that robots make, over REST."""

import asyncio
import threading
from pathlib import Path

import httpx
import numpy as np
import pytest

from endpoints.resources.joint_maps import RobotMap
from endpoints.resources.publications import ProgressFile, Stage
from endpoints.resources.services import Services
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import OCCUPIED
from ppaas.planar_poses import compose
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.world.mappings import room_mapping
from tests.support.world.voxels import grid
from tests.unit.endpoints.conftest import LogIn, Publish

MAP = "/v1/robots/tb1/map"


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> dict[str, str]:
    """Return the headers of a user with a robot that makes a map."""
    headers = await log_in("ann")
    await client.put("/v1/robots/tb1", headers=headers, json={"map": "new:office-2"})
    cloud.map_file = b"".join(pack_mapping(room_mapping(8)))
    return headers


async def test_the_size_of_the_map_so_far_is_shown(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    answer = await client.get(MAP, headers=ann)
    size = {"key_frames": 3, "edges": 2, "closures": 0}
    assert answer.json() == size | {"joined_with": [], "refused": None, "tried": None, "publishing": None}


async def test_the_robots_with_which_the_map_is_made_are_shown(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    joint = services.joint_maps
    maps = [RobotMap("ann", "tb1", "a", 30, 50), RobotMap("bob", "tb9", "b", 30, 90)]
    joint.report({"new:office-2@ann": maps})
    join = joint.next_join()
    assert join is not None
    joint.done(join, 60, "the maps do not overlap enough: too few places")
    answer = (await client.get(MAP, headers=ann)).json()
    assert (answer["joined_with"], answer["refused"]) == ([], "the maps do not overlap enough: too few places")
    joint.report({"new:office-2@ann": [maps[0], maps[1]._replace(frame="a")]})
    answer = (await client.get(MAP, headers=ann)).json()
    assert (answer["joined_with"], answer["refused"]) == (["bob/tb9"], None)


async def test_the_pose_graph_so_far_is_returned(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    answer = await client.get(f"{MAP}/posegraph", headers=ann)
    assert answer.content == cloud.map_file


async def test_the_map_is_published_with_its_pose_graph(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    published = await client.post(MAP, headers=ann, json={"publish": "office-2", "message": "first walk"})
    assert (published.status_code, published.json()["parts"]) == (201, ["image", "posegraph", "yaml"])
    assert (published.json()["message"], published.json()["owner"]) == ("first walk", "ann")
    with services.map_store.open_map("office-2") as opened:
        drawn = load_map(bytes(opened.buffers["yaml"]), bytes(opened.buffers["image"]))
        graph = unpack_mapping(bytes(opened.buffers["posegraph"]))
    assert 6.0 < drawn.info.width * drawn.info.resolution < 12.0
    before = unpack_mapping(cloud.map_file).frames.poses
    np.testing.assert_allclose(graph.frames.poses, before, atol=0.02)
    assert not np.array_equal(graph.frames.poses, before)


async def test_it_is_shown_how_far_a_publication_is(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_end = threading.Event(), threading.Event()

    def draw(_module: str, arguments: list[str], *_: object) -> None:
        ProgressFile(Path(arguments[0])).write(Stage.LOOPS, 0.25)
        begun.set()
        may_end.wait(10)
        raise Unavailable("no time")

    monkeypatch.setattr("endpoints.rest.robots.robot_map.run_program", draw)
    publishing = asyncio.create_task(client.post(MAP, headers=ann, json={"publish": "office-2"}))
    await asyncio.to_thread(begun.wait, 10)
    assert (await client.get(MAP, headers=ann)).json()["publishing"] == {"stage": "loops", "part": 0.25}
    may_end.set()
    problem_of(await publishing, 503, "unavailable")
    assert (await client.get(MAP, headers=ann)).json()["publishing"] is None


async def test_a_3d_map_is_published_as_the_octomap_of_the_version(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    cloud.octomap_file = binary_octomap(octree_of(grid(np.full((3, 3, 3), OCCUPIED, np.uint8), 0.5)))
    published = await client.post(MAP, headers=ann, json={"publish": "office-2", "refine": False})
    assert published.json()["parts"] == ["image", "octomap", "posegraph", "yaml"]
    with services.map_store.open_map("office-2") as opened:
        assert bytes(opened.buffers["octomap"]) == cloud.octomap_file


async def test_the_octomap_moves_with_the_key_frames_that_are_refined(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    cloud.octomap_file = binary_octomap(octree_of(grid(np.full((3, 3, 3), OCCUPIED, np.uint8), 0.5)))
    await client.post(MAP, headers=ann, json={"publish": "office-2"})
    assert cloud.octomaps_asked[0].before == []
    mapping = unpack_mapping(cloud.map_file)
    robot = compose(mapping.frames.poses, np.array(mapping.frames.geometry.mount.inverse()))
    moved = next(request for request in cloud.octomaps_asked if request.before)
    np.testing.assert_allclose(np.reshape(moved.before, (-1, 3)), robot, atol=1e-9)
    assert 0.0 < np.abs(np.subtract(moved.after, moved.before)).max() < 0.02
    with services.map_store.open_map("office-2") as opened:
        assert bytes(opened.buffers["octomap"]) == cloud.octomap_file


async def test_a_map_of_another_user_is_not_replaced(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn, publish: Publish
) -> None:
    await publish(await log_in("bob"))
    problem = problem_of(await client.post(MAP, headers=ann, json={"publish": "house"}), 409, "conflict")
    assert "belongs to another user" in problem["detail"]


@pytest.mark.parametrize(
    ("error", "status", "slug"),
    [(Unavailable("no container now"), 503, "unavailable"), (Conflict("it makes no map"), 409, "conflict")],
)
async def test_a_robot_that_makes_no_map_is_reported(
    error: PPaaSError, status: int, slug: str, client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.error = error
    problem_of(await client.post(MAP, headers=ann, json={"publish": "office-2"}), status, slug)


async def test_a_robot_that_has_mapped_nothing_is_told_before_anything_is_drawn(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.map_file = b""
    problem = problem_of(await client.post(MAP, headers=ann, json={"publish": "office-2"}), 409, "conflict")
    assert "has mapped nothing yet" in problem["detail"]


async def test_a_damaged_pose_graph_publishes_nothing(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    cloud.map_file = cloud.map_file[:-3]
    problem_of(await client.post(MAP, headers=ann, json={"publish": "office-2"}), 422, "invalid-map")
    assert services.map_store.maps() == []


async def test_maps_of_other_users_robots_are_not_found(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    bob = await log_in("bob")
    problem_of(await client.get(MAP, headers=bob), 404, "not-found")
    problem_of(await client.post(MAP, headers=bob, json={"publish": "office-2"}), 404, "not-found")


@pytest.mark.parametrize("body", [{}, {"publish": "new:x"}, {"publish": "a", "refine": 3}, {"publish": "a", "x": 1}])
async def test_an_invalid_request_is_refused(
    body: dict[str, object], client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    problem_of(await client.post(MAP, headers=ann, json=body), 422, "invalid-request")


async def test_a_map_that_is_published_again_keeps_its_zones(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    await client.post(MAP, headers=ann, json={"publish": "office-2", "refine": False})
    zones = {"type": "FeatureCollection", "features": [STAIRS]}
    assert (await client.put("/v1/maps/office-2/zones", headers=ann, json=zones)).status_code == 200
    published = await client.post(MAP, headers=ann, json={"publish": "office-2", "refine": True})
    assert published.json()["parts"] == ["image", "posegraph", "yaml", "zones"]
    kept = (await client.get("/v1/maps/office-2/zones", headers=ann)).json()
    assert [zone["properties"]["name"] for zone in kept["features"]] == ["stairs"]


STAIRS = {
    "type": "Feature",
    "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [0.5, 0], [0.5, 0.5], [0, 0]]]},
    "properties": {"name": "stairs", "kind": "keep_out"},
}

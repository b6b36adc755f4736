"""Map versions over REST: list, differences, roll back, and octomaps."""

import asyncio

import httpx
import numpy as np
import pytest

from endpoints.resources.services import Services
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import VoxelGrid, VoxelInfo
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, pgm
from tests.support.world.mappings import room_mapping
from tests.unit.endpoints.conftest import LogIn, Publish

TREE = binary_octomap(octree_of(VoxelGrid(np.full((2, 2, 3), 100, np.uint8), VoxelInfo(0.1, 3, 2, 2))))


async def send_octomap(
    client: httpx.AsyncClient, headers: dict[str, str], octomap: bytes = TREE, **files: bytes
) -> httpx.Response:
    given = {name: (name, data) for name, data in (files | {"octomap": octomap}).items()}
    return await client.post("/v1/maps", headers=headers, data={"id": "house"}, files=given)


async def test_versions_list_author_and_message(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann, admin = await log_in("ann"), await log_in("admin")
    first = (await publish(ann, message="as built")).json()
    second = (await publish(admin, image=pgm(5, 6), message="an annexe")).json()
    assert (first["author"], second["author"], second["owner"]) == ("ann", "admin", "ann")
    items = (await client.get("/v1/maps/house/versions", headers=ann)).json()["items"]
    assert [(one["author"], one["message"], one["present"]) for one in items] == [
        ("admin", "an annexe", True),
        ("ann", "as built", False),
    ]
    assert items[0]["number"] > items[1]["number"]
    shown = (await client.get(f"/v1/maps/house/versions/{first['version']}", headers=ann)).json()
    assert (shown["message"], shown["width"]) == ("as built", 4)


async def test_a_map_is_rolled_back_to_an_older_version(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    first = (await publish(ann, readers="bob")).json()
    second = (await publish(ann, image=pgm(5, 6))).json()
    path = "/v1/maps/house/roll_back"
    body = {"version": first["version"], "message": "the annexe is gone"}
    for user, status, slug in (("bob", 403, "not-permitted"), ("carl", 404, "not-found")):
        problem_of(await client.post(path, headers=await log_in(user), json=body), status, slug)
    expected = {"If-Match": f'"{first["version"]}"'}
    problem_of(await client.post(path, headers=ann | expected, json=body), 409, "conflict")
    expected = {"If-Match": f'"{second["version"]}"'}
    answer = (await client.post(path, headers=ann | expected, json=body)).json()
    assert (answer["version"], answer["restored"], answer["message"]) == (first["version"], True, "the annexe is gone")
    assert (await client.get("/v1/maps/house", headers=ann)).json()["width"] == 4
    assert (await client.get("/v1/maps/house/image", headers=ann)).content == pgm()
    problem_of(await client.post(path, headers=ann, json={"version": "f" * 64}), 404, "not-found")
    problem_of(await client.post(path, headers=ann, json={"version": "../x"}), 422, "invalid-request")


async def test_concurrent_publications_with_the_same_if_match_conflict(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    first = (await publish(ann)).json()["version"]
    headers = ann | {"If-Match": f'"{first}"'}
    answers = await asyncio.gather(*(publish(headers, image=pgm(value=value)) for value in (1, 2, 3)))
    assert sorted(answer.status_code for answer in answers) == [201, 409, 409]
    problem_of(await publish(ann | {"If-Match": '"../x"'}), 400, "invalid-input")


async def test_the_difference_of_two_versions_is_described(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    first = (await publish(ann)).json()["version"]
    image = bytearray(pgm(5, 3))
    image[-5] = 0
    second = (await publish(ann, image=bytes(image))).json()["version"]
    diff = (await client.get("/v1/maps/house/difference", headers=ann, params={"old": first})).json()
    assert (diff["old"], diff["new"], diff["changed"], diff["aligned"]) == (first, second, 4, True)
    assert diff["rectangle"] == {"column": 0, "row": 0, "width": 5, "height": 3}
    assert diff["corners"][0] == pytest.approx([-1.0, -2.0])
    assert diff["octomap"] == "none"
    same = (await client.get("/v1/maps/house/difference", headers=ann, params={"old": first, "new": first})).json()
    assert (same["changed"], same["rectangle"], same["corners"]) == (0, None, None)
    unknown = await client.get("/v1/maps/house/difference", headers=ann, params={"old": "f" * 64})
    problem_of(unknown, 404, "not-found")
    hidden = await client.get("/v1/maps/house/difference", headers=await log_in("bob"), params={"old": first})
    problem_of(hidden, 404, "not-found")


async def test_an_octomap_is_stored_verbatim_with_or_without_a_grid(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann = await log_in("ann")
    alone = await send_octomap(client, ann)
    assert (alone.status_code, alone.json()["parts"], alone.json()["resolution"]) == (201, ["octomap"], None)
    assert (await client.get("/v1/maps/house/octomap", headers=ann)).content == TREE
    problem_of(await client.get("/v1/maps/house/image", headers=ann), 404, "not-found")
    problem_of(await client.get("/v1/maps/house/cells", headers=ann), 422, "invalid-map")
    both = (await send_octomap(client, ann, yaml=YAML, image=pgm())).json()
    assert (both["parts"], both["width"]) == (["image", "octomap", "yaml"], 4)
    path = f"/v1/maps/house/versions/{alone.json()['version']}/octomap"
    assert (await client.get(path, headers=ann)).content == TREE
    no_grid = await client.get("/v1/maps/house/difference", headers=ann, params={"old": alone.json()["version"]})
    problem_of(no_grid, 422, "invalid-map")


@pytest.mark.parametrize(
    "octomap",
    [
        b"P5 1 1 255 x",
        TREE[:-1],
        TREE.replace(b"size", b"size 9"),
        b"# Octomap OcTree binary file\nid OcTree\nsize 999999999999999\nres 0.1\ndata\n" + bytes(64),
    ],
)
async def test_invalid_octomaps_are_refused_and_not_stored(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, octomap: bytes
) -> None:
    problem_of(await send_octomap(client, await log_in("ann"), octomap), 422, "invalid-map")
    assert services.map_store.maps() == []


async def test_a_pose_graph_is_stored_verbatim_beside_its_grid(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann, graph = await log_in("ann"), b"".join(pack_mapping(room_mapping(3)))
    files = {"yaml": ("yaml", YAML), "image": ("image", pgm()), "posegraph": ("posegraph", graph)}
    published = await client.post("/v1/maps", headers=ann, data={"id": "house"}, files=files)
    assert (published.status_code, published.json()["parts"]) == (201, ["image", "posegraph", "yaml"])
    path = f"/v1/maps/house/versions/{published.json()['version']}/posegraph"
    for url in (path, "/v1/maps/house/posegraph"):
        assert (await client.get(url, headers=ann)).content == graph
    files["posegraph"] = ("posegraph", graph[:-1])
    damaged = await client.post("/v1/maps", headers=ann, data={"id": "house"}, files=files)
    assert "cut off" in problem_of(damaged, 422, "invalid-map")["detail"]
    with_octree = {"posegraph": ("posegraph", graph), "octomap": ("octomap", TREE)}
    lone = await client.post("/v1/maps", headers=ann, data={"id": "house"}, files=with_octree)
    assert "send 'yaml' and 'image'" in problem_of(lone, 422, "invalid-parameter")["detail"]


async def test_every_version_of_a_map_stays_readable(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    first = (await publish(ann)).json()
    second = (await publish(ann, image=pgm(5, 6, 0))).json()
    path = f"/v1/maps/house/versions/{first['version']}"
    assert (await client.get(path, headers=ann)).json() | {"warnings": []} == first
    assert (await client.get(f"{path}/yaml", headers=ann)).content == YAML
    image = await client.get(f"{path}/image", headers=ann)
    assert (image.content, image.headers["content-type"]) == (pgm(), "image/x-portable-graymap")
    assert (await client.get("/v1/maps/house", headers=ann)).json()["version"] == second["version"]
    for end in ("", "/yaml", "/image"):
        problem_of(await client.get(path + end, headers=bob), 404, "not-found")
        unknown = f"/v1/maps/house/versions/{'0' * 64}{end}"
        assert (
            "version of map 'house'" in problem_of(await client.get(unknown, headers=ann), 404, "not-found")["detail"]
        )


# Transfer of a map's cells; their values are tested in ppaas.maps.


async def test_cells_are_gzipped_for_clients_that_accept_gzip(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    plain = await client.get("/v1/maps/house/cells", headers=ann | {"Accept-Encoding": "identity"})
    packed = await client.get("/v1/maps/house/cells", headers=ann | {"Accept-Encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert (packed.headers["content-encoding"], packed.headers["vary"]) == ("gzip", "Accept-Encoding")
    assert packed.content == plain.content
    described = (await client.get("/v1/maps/house", headers=ann)).json()
    assert len(plain.content) == described["width"] * described["height"]


async def test_cells_of_an_earlier_version_are_sent(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    first = (await publish(ann, image=pgm(value=0))).json()["version"]
    await publish(ann, image=pgm(value=255))
    old, new = [await client.get(f"/v1/maps/house/cells{query}", headers=ann) for query in (f"?version={first}", "")]
    assert (old.status_code, set(old.content), set(new.content)) == (200, {100}, {0})
    problem_of(await client.get(f"/v1/maps/house/cells?version={'0' * 64}", headers=ann), 404, "not-found")
    display = {"robots": ["*"], "role": "look", "name": "display"}
    token = (await client.post("/v1/scoped-tokens", headers=ann, json=display)).json()["token"]
    scoped = await client.get(f"/v1/maps/house/cells?version={first}", headers={"Authorization": f"Bearer {token}"})
    problem_of(scoped, 403, "not-permitted")


async def test_cells_require_read_access_to_the_map(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    await publish(await log_in("ann"))
    assert (await client.get("/v1/maps/house/cells")).status_code == 401
    assert (await client.get("/v1/maps/house/cells", headers=await log_in("bob"))).status_code == 404

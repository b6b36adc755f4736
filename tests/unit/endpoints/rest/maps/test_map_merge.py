"""Merges of published maps over REST."""

from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from endpoints.rest.maps import map_merge
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.merging.merge import merge
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.formats.map_files import load_map
from tests.support.endpoints.problems import problem_of
from tests.support.storage.mapped_maps import put_mapping
from tests.support.world.mappings import room_mapping
from tests.support.world.merge_drives import first_mapping, second_mapping
from tests.unit.endpoints.conftest import LogIn, Publish

MERGE = "/v1/maps/north/merge"


@pytest.fixture
async def ann(log_in: LogIn, services: Services) -> dict[str, str]:
    """Publish ann's maps: both of one ring of corridors, and one of another room."""
    headers = await log_in("ann")
    put_mapping(services.map_store, "north", first_mapping(), readers=("bob",))
    put_mapping(services.map_store, "south", second_mapping())
    put_mapping(services.map_store, "room", room_mapping(40))
    return headers


async def test_two_maps_become_one(client: httpx.AsyncClient, ann: dict[str, str], services: Services) -> None:
    answer = await client.post(MERGE, headers=ann, json={"with": "south", "into": "both"})
    assert answer.status_code == 201, answer.text
    made: dict[str, Any] = answer.json()
    first, second = (unpack_mapping(b"".join(pack_mapping(one()))) for one in (first_mapping, second_mapping))
    expected = merge(first, second)
    assert (made["id"], made["owner"], made["parts"]) == ("both", "ann", ["image", "posegraph", "yaml"])
    assert made["message"] == "merge of north and south"
    assert made["places"] == expected.matches
    assert made["motion"] == pytest.approx(list(expected.motion), abs=1e-3)
    with services.map_store.open_map("both") as opened:
        mapping = unpack_mapping(bytes(opened.buffer("posegraph")))
        grid = load_map(bytes(opened.buffer("yaml")), bytes(opened.buffer("image")))
    assert len(mapping.frames) == len(first.frames) + len(second.frames)
    assert (draw_map(mapping.frames, mapping.frames.poses).data == grid.data).mean() > 0.999
    (event,) = services.audit.read(AuditQuery(action="merge_map"))
    assert (event.object, event.details["merged"]) == ("maps/both", ["north", "south"])


async def test_maps_of_different_places_are_refused_and_nothing_is_published(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    answer = await client.post(MERGE, headers=ann, json={"with": "room", "into": "both"})
    problem = problem_of(answer, 409, "maps-not-merged")
    assert "too few places" in problem["detail"]
    assert (await client.get("/v1/maps/both", headers=ann)).status_code == 404


async def test_a_map_without_pose_graph_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], publish: Publish
) -> None:
    await publish(ann)
    answer = await client.post(MERGE, headers=ann, json={"with": "house", "into": "both"})
    assert "map 'house' has no pose graph" in problem_of(answer, 409, "conflict")["detail"]


@pytest.mark.parametrize(
    ("body", "header", "told"),
    [({"into": "house"}, {}, "belongs to another user"), ({"into": "north"}, {"If-Match": "0" * 64}, "is at version")],
)
async def test_a_merge_that_cannot_be_published_is_refused_before_the_work(
    client: httpx.AsyncClient,
    ann: dict[str, str],
    publish: Publish,
    log_in: LogIn,
    monkeypatch: pytest.MonkeyPatch,
    body: dict[str, str],
    header: dict[str, str],
    told: str,
) -> None:
    await publish(await log_in("bob"))
    monkeypatch.delattr(map_merge, "merge_in_process")
    answer = await client.post(MERGE, headers=ann | header, json={"with": "south"} | body)
    assert told in problem_of(answer, 409, "conflict")["detail"]


async def test_only_readable_maps_are_merged_and_only_own_maps_are_replaced(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    bob = await log_in("bob")
    hidden = await client.post(MERGE, headers=bob, json={"with": "south", "into": "both"})
    problem_of(hidden, 404, "not-found")
    foreign = await client.post("/v1/maps/south/merge", headers=bob, json={"with": "north", "into": "both"})
    problem_of(foreign, 404, "not-found")

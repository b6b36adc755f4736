"""Change watch: what a robot that maps for life has confirmed becomes a reviewed version."""

import json
import logging
from functools import cache
from pathlib import Path
from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.proposals import change_watch
from endpoints.proposals.change_program import find
from endpoints.proposals.change_watch import ChangeWatch
from endpoints.resources.services import Services
from endpoints.rest.maps.map_programs import outcome_of
from engine.control.views import LifelongRobot
from ppaas.errors import QuotaExceeded, Unavailable, rebuild
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.maps.formats.map_files import save_map
from storage.records import Publication
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.world.changing_rounds import CHAIR, TABLE, mapped, with_boxes
from tests.unit.endpoints.conftest import LogIn

ROBOT = LifelongRobot("ann", "tb1", "office")
REVIEWS = "/v1/maps/office/reviews"


def file_of(frames: KeyFrames, graph: PoseGraph) -> bytes:
    return b"".join(pack_mapping(Mapping(frames, graph, "laser")))


@cache
def base() -> tuple[KeyFrames, PoseGraph]:
    return mapped(*[with_boxes(CHAIR)] * 2)


@cache
def same_file() -> bytes:
    return file_of(*mapped(*[with_boxes(CHAIR)] * 3, after=base()))


@cache
def moved_file() -> bytes:
    return file_of(*mapped(*[with_boxes(TABLE)] * 5, after=base()))


@pytest.fixture(autouse=True)
def _program(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """Run the program in this process, which is faster."""

    def run(_module: str, arguments: list[str], *_: object) -> object:
        outcome = outcome_of(lambda: find(Path(arguments[0])), QuotaExceeded("too large"))
        if "fault" in outcome:
            raise rebuild(*outcome["fault"])
        return json.loads(json.dumps(outcome["result"]))

    if request.function is not test_maps_are_compared_in_a_process_of_its_own:
        monkeypatch.setattr(change_watch, "run_program", run)


@pytest.fixture
async def ann(log_in: LogIn, services: Services, cloud: FakeCloud) -> dict[str, str]:
    """Return the headers of a user with a robot that continues a published map, in which a box was moved."""
    headers = await log_in("ann")
    grid = draw_map(base()[0], base()[0].poses)
    record, pixels = save_map(grid, "map.pgm")
    with services.map_store.stage() as upload:
        for part, data in (("yaml", record), ("image", pixels), ("posegraph", file_of(*base()))):
            upload.add(part, [data])
        services.map_store.publish(upload, Publication("office", "ann", 0.0))
    cloud.lifelong, cloud.map_file = [ROBOT], moved_file()
    return headers


async def look(services: Services, watch: ChangeWatch | None = None) -> None:
    """Look twice, by default after a restart of the cloud."""
    watch = watch or ChangeWatch(services)
    for _ in range(2):
        await watch.step()


async def reviews(client: httpx.AsyncClient, headers: dict[str, str]) -> list[dict[str, Any]]:
    listed: dict[str, Any] = (await client.get(REVIEWS, headers=headers)).json()
    return list(listed["items"])


async def test_a_confirmed_change_waits_for_a_review(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    await look(services)
    (review,) = await reviews(client, ann)
    assert (review["author"], review["state"], review["parts"]) == ("ann", "waiting", ["image", "posegraph", "yaml"])
    assert review["message"].startswith("tb1: two passes show gone: 1 place, ")
    assert "; new: 1 place, " in review["message"]
    assert review["occupied"] > 5 and review["free"] > 5 and review["unknown"] == 0
    (event,) = services.audit.read(AuditQuery(action="propose_change"))
    assert (event.user, event.object, event.details["robot"]) == ("ann", "maps/office", "tb1")


async def test_a_proposal_keeps_the_other_files_of_the_map(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    with services.map_store.open_map("office") as opened, services.map_store.stage() as upload:
        upload.add("octomap", [b"octomap"])
        upload.add("zones", [b"zones"])
        for part, data in opened.buffers.items():
            upload.add(part, [bytes(data)])
        services.map_store.publish(upload, Publication("office", "ann", 1.0))
    await look(services)
    (review,) = await reviews(client, ann)
    assert review["parts"] == ["image", "octomap", "posegraph", "yaml", "zones"]
    assert services.map_store.reviews("office")[0].keeps_zones
    with services.map_store.open_map("office", review["version"]) as opened:
        assert bytes(opened.buffer("octomap")) == b"octomap"


async def test_at_most_one_proposal_of_a_robot_waits(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    for _ in range(2):
        await look(services)
    assert len(await reviews(client, ann)) == 1


async def test_an_approved_change_is_the_map_and_is_not_proposed_again(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    await look(services)
    approved = await client.post(f"{REVIEWS}/2/approve", headers=ann, json={"why": "seen it"})
    assert approved.status_code == 200, approved.text
    assert cloud.changed_maps[-1] == ("office", approved.json()["version"])
    await look(services)
    assert [one["state"] for one in await reviews(client, ann)] == ["approved"]


async def test_a_change_that_was_approved_and_undone_is_proposed_again(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    before, watch = services.map_store.map_head("office").version, ChangeWatch(services)
    await look(services, watch)
    await client.post(f"{REVIEWS}/2/approve", headers=ann, json={"why": "seen it"})
    undone = await client.post("/v1/maps/office/roll_back", headers=ann, json={"version": before})
    assert undone.status_code == 200, undone.text
    await look(services, watch)  # the robot stands
    assert [one["state"] for one in await reviews(client, ann)] == ["waiting", "approved"]


async def test_a_refused_change_is_not_proposed_again_by_any_robot(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    await look(services)
    await client.post(f"{REVIEWS}/2/refuse", headers=ann, json={"why": "it was a fair"})
    cloud.lifelong.append(LifelongRobot("ann", "tb2", "office"))
    await look(services)
    assert [one["state"] for one in await reviews(client, ann)] == ["refused"]


async def test_a_place_that_stayed_the_same_is_not_proposed(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    cloud.map_file = same_file()
    await look(services)
    assert await reviews(client, ann) == []


async def test_what_one_look_found_is_not_proposed(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    watch = ChangeWatch(services)
    await watch.step()
    assert await reviews(client, ann) == []
    cloud.map_file = same_file()
    watch._seen.clear()
    await watch.step()
    cloud.map_file = moved_file()
    watch._seen.clear()
    await watch.step()
    assert await reviews(client, ann) == []
    await watch.step()
    assert len(await reviews(client, ann)) == 1


async def test_a_robot_is_looked_at_again_when_its_map_has_grown(
    ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch, taken = ChangeWatch(services), []
    monkeypatch.setattr(watch, "_propose", lambda *given: taken.append(given))
    await watch.step()
    await watch.step()
    assert len(taken) == 1


async def test_a_robot_that_does_not_answer_is_no_fault(
    ann: dict[str, str], services: Services, cloud: FakeCloud, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    cloud.error = Unavailable("the robot has no container now")
    await look(services)
    assert "map 'office' is not compared with that of robot 'tb1': the robot has no container now" in caplog.text


async def test_robots_whose_user_may_not_propose_are_not_looked_at(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn, services: Services, cloud: FakeCloud,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    caplog.set_level(logging.INFO)
    await log_in("bob")
    await client.patch("/v1/maps/office", headers=ann, json={"readers": ["*"]})
    cloud.lifelong = [LifelongRobot("bob", "tb9", "office")]
    await look(services)
    assert caplog.text.count("the readers named by the owner may propose versions") == 1
    assert await reviews(client, ann) == []


async def test_another_map_of_the_same_id_is_not_compared(
    client: httpx.AsyncClient,
    ann: dict[str, str],
    services: Services,
    cloud: FakeCloud,
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO)
    cloud.map_file = file_of(*mapped(with_boxes(TABLE)))
    await look(services)
    assert "does not continue this map: its first key frame is another one" in caplog.text
    assert await reviews(client, ann) == []


async def test_maps_are_compared_in_a_process_of_its_own(ann: dict[str, str], services: Services) -> None:
    watch = ChangeWatch(services)
    await watch.step()
    found = watch._found[ROBOT]
    assert (len(found.left), len(found.new)) == (1, 1)

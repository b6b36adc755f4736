"""Maps over REST."""

import hashlib
from pathlib import Path
from typing import Any

import httpx
import pytest

from endpoints.resources.services import Services
from engine.specs.containers import MapVersion
from ppaas.errors import Unavailable
from ppaas.plans.history import PlannerHistory
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, found_map, pgm, plan
from tests.support.world.png import png
from tests.unit.endpoints.conftest import LogIn, Publish


async def test_a_published_map_is_described_and_returned_unchanged(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    made = await publish(ann, readers="bob, carl,bob")
    assert made.status_code == 201
    body = made.json()
    assert body.pop("warnings") == []
    assert body == (await client.get("/v1/maps/house", headers=ann)).json()
    assert body.pop("created") > 1.6e9
    files = {"image": pgm(), "yaml": YAML}
    lines = [f"{part} {hashlib.sha256(data).hexdigest()}\n" for part, data in files.items()]
    version = hashlib.sha256("".join(lines).encode()).hexdigest()
    expected = {"id": "house", "owner": "ann", "version": version, "readers": ["bob", "carl"], "description": ""}
    expected["traffic"] = False
    expected |= {"author": "ann", "message": "", "restored": False, "parts": ["image", "yaml"]}
    expected |= {"resolution": 0.05, "width": 4, "height": 3, "origin": [-1.0, -2.0, 0.0], "georeference": None}
    assert body == expected
    assert (await client.get("/v1/maps/house/yaml", headers=ann)).content == YAML
    assert (await client.get("/v1/maps/house/image", headers=ann)).content == pgm()


async def test_a_map_is_visible_to_owner_readers_and_admins_only(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    for map_id, readers in (("private", ""), ("shared", "bob"), ("public", "*")):
        await publish(ann, map_id, readers=readers)
    seen = {"ann": 3, "bob": 2, "carl": 1, "admin": 3}
    for user, count in seen.items():
        header = await log_in(user)
        listed = [m["id"] for m in (await client.get("/v1/maps", headers=header)).json()["items"]]
        assert listed == ["private", "public", "shared"] if count == 3 else ["public", "shared"][:count]
    bob = await log_in("bob")
    for path in ("/v1/maps/private", "/v1/maps/private/yaml", "/v1/maps/private/image"):
        assert problem_of(await client.get(path, headers=bob), 404, "not-found")["detail"] == "unknown map 'private'"
    assert (await client.get("/v1/maps/shared/image", headers=bob)).content == pgm()


async def test_a_new_version_replaces_the_old_and_keeps_the_readers(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    first = (await publish(ann, readers="bob")).json()
    second = (await publish(ann, image=pgm(5, 6, 0))).json()
    assert first["version"] != second["version"]
    assert (second["width"], second["height"], second["readers"]) == (5, 6, ["bob"])
    assert (await publish(ann, readers="")).json()["readers"] == []


async def test_only_the_owner_and_admins_publish_to_a_map_id(
    log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    problem_of(await publish(await log_in("bob"), image=pgm(9, 9)), 409, "conflict")
    assert found_map(services.map_store).image == pgm()
    mended = await publish(await log_in("admin"), image=pgm(9, 9))
    assert (mended.status_code, mended.json()["owner"]) == (201, "ann")


async def test_only_the_owner_and_admins_remove_a_map_not_in_use(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann, readers="bob")
    problem_of(await client.delete("/v1/maps/house", headers=bob), 403, "not-permitted")
    cloud.running = [container("c1", user="bob")]
    problem_of(await client.delete("/v1/maps/house", headers=ann), 409, "conflict")
    cloud.running = [container("c1", user="bob", map=MapVersion("hall", "v"), masks=("slow", "house"))]
    problem_of(await client.delete("/v1/maps/house", headers=ann), 409, "conflict")
    cloud.running = [container("c2", kind="planning", robot=None)]
    assert (await client.delete("/v1/maps/house", headers=ann)).status_code == 204
    problem_of(await client.delete("/v1/maps/house", headers=ann), 404, "not-found")
    await publish(bob)
    assert (await client.delete("/v1/maps/house", headers=await log_in("admin"))).status_code == 204


async def test_removing_a_map_removes_its_plans_and_history(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await publish(ann, id="yard")
    services.store.add_plans([plan("p1"), plan("p2", user="bob"), plan("p3", map="yard")])
    services.store.add_history(PlannerHistory(name, "v", "dijkstra", 3, queries=1) for name in ("house", "yard"))
    assert (await client.delete("/v1/maps/house", headers=ann)).status_code == 204
    assert services.store.plan_maps() == services.store.history_maps() == ["yard"]


async def test_a_map_stays_if_its_plans_cannot_be_removed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    services.store.add_plan(plan("p1"))

    def unreachable(_self: object, _map_id: str) -> int:
        raise Unavailable("far: no node answers")

    with monkeypatch.context() as patch:
        patch.setattr(type(services.store), "remove_plans", unreachable)
        problem_of(await client.delete("/v1/maps/house", headers=ann), 503, "unavailable")
    assert (await client.get("/v1/maps/house", headers=ann)).status_code == 200
    assert (await client.delete("/v1/maps/house", headers=ann)).status_code == 204
    assert services.store.plan_maps() == []


@pytest.mark.parametrize(
    ("yaml", "image"),
    [
        (b"", pgm()),
        (b"\xff\x00rubbish: [", pgm()),
        (b"image: x\nresolution: .nan\norigin: [0, 0, 0]\n", pgm()),
        (YAML, b""),
        (YAML, b"\x89PNG\r\n\x1a\n" + bytes(50)),
        (YAML, pgm()[:-1]),
        (YAML, b"P5\n100000 100000\n255\n"),
    ],
)
async def test_invalid_map_files_are_refused_and_the_map_stays(
    log_in: LogIn, publish: Publish, services: Services, yaml: bytes, image: bytes
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    problem_of(await publish(ann, yaml=yaml, image=image), 422, "invalid-map")
    assert found_map(services.map_store).image == pgm()


@pytest.mark.parametrize("map_id", ["", "../house", "a/b", "-x", "x" * 65, "a\x00"])
async def test_an_invalid_map_id_is_refused(log_in: LogIn, publish: Publish, map_id: str) -> None:
    problem_of(await publish(await log_in("ann"), map_id), 400, "invalid-input")


async def test_a_failing_store_is_unavailable_with_retry_after(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_map_id: str) -> None:
        raise Unavailable("the disk is full: free space")

    ann = await log_in("ann")
    monkeypatch.setattr(services.map_store, "map_head", fail)
    answer = await client.get("/v1/maps/house", headers=ann)
    problem_of(answer, 503, "unavailable")
    assert int(answer.headers["retry-after"]) >= 1


async def test_a_real_map_is_published(client: httpx.AsyncClient, log_in: LogIn, publish: Publish, data: Path) -> None:
    folder = data / "ros"
    yaml = next(iter(sorted(folder.glob("**/*turtlebot3*.yaml"))))
    image = yaml.with_suffix(".pgm").read_bytes()
    made = await publish(await log_in("ann"), yaml=yaml.read_bytes(), image=image)
    assert (made.status_code, made.json()["width"], made.json()["height"]) == (201, 384, 384)


async def test_a_png_is_published_and_returned_unchanged(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, image = await log_in("ann"), png([b"\x00\xfe\xcd", b"\xfe\xfe\xfe"], 3)
    made = await publish(ann, image=image)
    assert (made.status_code, made.json()["width"], made.json()["height"]) == (201, 3, 2)
    fetched = await client.get("/v1/maps/house/image", headers=ann)
    assert (fetched.content, fetched.headers["content-type"]) == (image, "image/png")
    cells = await client.get("/v1/maps/house/cells", headers=ann)
    assert cells.content == bytes([0, 0, 0, 100, 0, 255])


async def test_a_map_is_shown_with_its_georeference(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann, anchor = await log_in("ann"), [48.137154, 11.576124, 0.5]
    made = await publish(ann, yaml=YAML + b"georeference: [48.137154, 11.576124, 0.5]\n")
    assert made.json()["georeference"] == anchor
    assert (await client.get("/v1/maps/house", headers=ann)).json()["georeference"] == anchor
    wrong = (await publish(ann, yaml=YAML + b"georeference: [91.0, 11.5, 0.0]\n")).json()
    assert wrong["georeference"] is None
    assert "a latitude between -90 and 90" in wrong["warnings"][0]
    assert (await client.get("/v1/maps/house", headers=ann)).json()["georeference"] is None


async def test_occupancy_rules_are_stored_with_the_map(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    """At the threshold itself a cell is free by Nav2's rules, and unknown by map_server's."""
    ann, yaml = await log_in("ann"), YAML.replace(b"free_thresh: 0.196", b"free_thresh: 0.0")
    for rules, cell in (({}, 255), ({"rules": "nav2"}, 0), ({"rules": "map_server"}, 255)):
        assert (await publish(ann, yaml=yaml, image=pgm(1, 1, 255), **rules)).status_code == 201
        assert (await client.get("/v1/maps/house/cells", headers=ann)).content == bytes([cell])
    problem = problem_of(await publish(ann, rules="gmapping"), 422, "invalid-parameter")
    assert problem["detail"] == "rules must be map_server or nav2, not 'gmapping'"
    without = yaml.replace(b"free_thresh: 0.0", b"")
    assert "Nav2" in problem_of(await publish(ann, yaml=without, rules="nav2"), 422, "invalid-map")["detail"]


MERGE = {"Content-Type": "application/merge-patch+json"}


# Changes of maps: readers and description.


async def test_the_owner_changes_readers_and_description(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    made = (await publish(ann, description="the ground floor")).json()
    changed = await client.patch("/v1/maps/house", headers=ann | MERGE, content='{"readers": ["bob", "bob"]}')
    assert (changed.json()["readers"], changed.json()["description"]) == (["bob"], "the ground floor")
    assert changed.json()["version"] == made["version"]
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 403, "not-permitted")
    emptied = await client.patch("/v1/maps/house", headers=ann, json={"readers": None, "description": None})
    assert (emptied.json()["readers"], emptied.json()["description"]) == ([], "")
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 404, "not-found")


@pytest.mark.parametrize(
    "change",
    [
        {"readers": ["../x"]},
        {"readers": "bob"},
        {"readers": ["u"] * 257},
        {"description": "x" * 1001},
        {"owner": "bob"},
    ],
)
async def test_invalid_map_changes_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    before = (await client.get("/v1/maps/house", headers=ann)).json()
    answer = await client.patch("/v1/maps/house", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", next(iter(change))]
    assert (await client.get("/v1/maps/house", headers=ann)).json() == before

"""Buildings over REST: put, read, shared, checked, laid out and removed."""

import json
from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from endpoints.rest.buildings import buildings
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import building as stored_building
from tests.unit.endpoints.conftest import LogIn, Publish

HQ = "/v1/buildings/hq"
JSON = {"Content-Type": "application/json"}
TWO: dict[str, Any] = {
    "floors": [{"name": "L1", "map": "m1"}, {"name": "L2", "map": "m2", "elevation": 4.0, "anchor": [0.0, 0.0, 0.0]}],
    "lifts": [{"lift": "north", "wait": 30.0}],
}


def features() -> list[dict[str, Any]]:
    """Return a lift, and a dock before it, on the map of 4 × 3 cells of 5 cm, whose corner is at (-1, -2)."""
    ring = [[-0.99, -1.99], [-0.95, -1.99], [-0.95, -1.95], [-0.99, -1.95], [-0.99, -1.99]]
    return [
        feature("north car", "lift", {"type": "Polygon", "coordinates": [ring]}, lift="north"),
        feature("north door", "door", line([-0.99, -1.94], [-0.95, -1.94]), lift="north"),
        feature("charger", "dock", {"type": "Point", "coordinates": [-0.9, -1.9]}, yaw=1.5),
    ]


def feature(name: str, kind: str, geometry: Any, **fields: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": {"name": name, "kind": kind} | fields}


def line(*places: list[float]) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": places}


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Publish two maps of ann, joined by a lift, of which bob may read the first."""
    headers = await log_in("ann")
    await log_in("carl")
    for map_id, readers in (("m1", "bob"), ("m2", "")):
        await publish(headers, map_id, **({"readers": readers} if readers else {}))
        body = json.dumps({"type": "FeatureCollection", "features": features()})
        answer = await client.put(f"/v1/maps/{map_id}/zones", headers=headers | JSON, content=body)
        assert answer.status_code == 200, answer.text
    return headers | JSON


async def put(client: httpx.AsyncClient, headers: dict[str, str], body: Any = TWO, path: str = HQ, **said: str) -> Any:
    query = {name: said[name] for name in ("message",) if name in said}
    match = {"If-Match": said["match"]} if "match" in said else {}
    return await client.put(path, headers=headers | match, content=json.dumps(body), params=query)


async def test_a_building_is_put_and_shown(client: httpx.AsyncClient, ann: dict[str, str], services: Services) -> None:
    made = await put(client, ann, message="surveyed")
    assert (made.status_code, made.headers["etag"]) == (201, '"1"')
    shown = await client.get(HQ, headers=ann)
    assert shown.headers["etag"] == '"1"'
    found = shown.json()
    assert found["building"] == TWO
    told = {name: found[name] for name in ("id", "owner", "version", "author", "message", "present", "readers")}
    assert told == {
        "id": "hq", "owner": "ann", "version": 1, "author": "ann", "message": "surveyed", "present": True,
        "readers": [],
    }  # fmt: skip
    assert made.json() == found | {"warnings": []}
    assert (found["floors"], found["maps"], found["elevations"]) == (["L1", "L2"], ["m1", "m2"], [0.0, 4.0])
    [listed] = (await client.get("/v1/buildings", headers=ann)).json()["items"]
    assert listed == {name: value for name, value in found.items() if name != "building"}
    (event,) = services.audit.read(AuditQuery(action="put_building"))
    assert (event.object, event.details) == ("buildings/hq", {"version": 1, "floors": 2})


async def test_a_change_is_a_version_and_equal_buildings_are_none(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    await put(client, ann)
    assert (await put(client, ann)).json()["version"] == 1
    changed = TWO | {"lifts": [{"lift": "north", "wait": 10.0}]}
    answer = await put(client, ann, changed, message="a faster motor", match='"1"')
    assert (answer.status_code, answer.headers["etag"]) == (200, '"2"')
    versions = (await client.get(f"{HQ}/versions", headers=ann)).json()
    assert [(one["version"], one["message"], one["present"]) for one in versions] == [
        (2, "a faster motor", True),
        (1, "", False),
    ]
    old = (await client.get(f"{HQ}?version=1", headers=ann)).json()
    assert (old["building"]["lifts"], old["present"]) == ([{"lift": "north", "wait": 30.0}], False)
    problem_of(await client.get(f"{HQ}?version=3", headers=ann), 404, "not-found")


async def test_a_building_is_changed_only_if_it_is_the_expected_version(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    detail = problem_of(await put(client, ann, match='"1"'), 409, "conflict")["detail"]
    assert "does not exist, not at version 1" in detail
    await put(client, ann)
    problem_of(await put(client, ann, TWO | {"lifts": []}, match='"7"'), 409, "conflict")
    problem_of(await client.delete(HQ, headers=ann | {"If-Match": '"7"'}), 409, "conflict")
    assert (await client.delete(HQ, headers=ann | {"If-Match": '"1"'})).status_code == 204
    problem_of(await client.get(HQ, headers=ann), 404, "not-found")
    assert (await client.get("/v1/maps/m1", headers=ann)).status_code == 200, "its maps stay"


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ({}, "must have floors"),
        ({"floors": [{"name": "L1", "map": "m1"}, {"name": "L1", "map": "m2"}]}, "2 floors have the name 'L1'"),
        ({"floors": [{"name": "L1", "map": "nowhere"}]}, "floor 'L1': there is no map 'nowhere' that you may read"),
        ({"floors": [{"name": "L1", "map": "m1", "elevaton": 1.0}]}, "elevaton"),
        (TWO | {"lifts": [{"lift": "n"}, {"lift": "n"}]}, "2 lifts have the id 'n'"),
        (TWO | {"doors": [{"floor": "L9", "door": "d"}]}, "there is no floor 'L9'; the floors are L1, L2"),
    ],
)
async def test_a_building_that_is_not_valid_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], body: Any, text: str
) -> None:
    for answer in (
        await put(client, ann, body),
        await client.post(f"{HQ}/check", headers=ann, content=json.dumps(body)),
    ):
        assert text in problem_of(answer, 422, "invalid-building")["detail"]
    problem_of(await client.get(HQ, headers=ann), 404, "not-found")


async def test_a_body_must_be_json(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    problem_of(await client.put(HQ, headers=ann, content=b"{"), 422, "invalid-building")
    as_text = ann | {"Content-Type": "text/plain"}
    problem_of(await client.put(HQ, headers=as_text, content=b"{}"), 415, "unsupported-media-type")


async def test_its_readers_see_it_and_only_its_owner_changes_it(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    await put(client, ann)
    bob, carl = await log_in("bob") | JSON, await log_in("carl") | JSON
    problem_of(await client.get("/v1/buildings/ann:hq", headers=bob), 404, "not-found")
    shared = await client.patch(HQ, headers=ann, content=b'{"readers": ["bob", "bob"]}')
    assert (shared.json()["readers"], shared.json()["version"]) == (["bob"], 1)
    assert (await client.get("/v1/buildings/ann:hq", headers=bob)).json()["owner"] == "ann"
    assert [one["id"] for one in (await client.get("/v1/buildings", headers=bob)).json()["items"]] == ["hq"]
    assert (await client.get("/v1/buildings", headers=carl)).json()["items"] == []
    problem_of(await put(client, bob, path="/v1/buildings/ann:hq"), 403, "not-permitted")
    problem_of(await client.delete("/v1/buildings/ann:hq", headers=bob), 403, "not-permitted")
    problem_of(await put(client, carl, path="/v1/buildings/ann:hq"), 404, "not-found")
    problem_of(await client.patch(HQ, headers=ann, content=b'{"readers": ["nobody"]}'), 404, "not-found")
    admin = await log_in("admin") | JSON
    assert (await put(client, admin, TWO | {"lifts": []}, path="/v1/buildings/ann:hq")).json()["author"] == "admin"
    assert (await client.get(HQ, headers=ann)).json()["readers"] == ["bob"]


async def test_two_users_may_have_buildings_of_one_id(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    await put(client, ann)
    bob = await log_in("bob") | JSON
    one = {"floors": [{"name": "L1", "map": "m1"}]}
    assert (await put(client, bob, one)).status_code == 201
    detail = problem_of(await put(client, bob), 422, "invalid-building")["detail"]
    assert detail == "floor 'L2': there is no map 'm2' that you may read"
    admin = await log_in("admin")
    page = (await client.get("/v1/buildings?limit=1", headers=admin)).json()
    rest = (await client.get(f"/v1/buildings?limit=1&cursor={page['next']}", headers=admin)).json()
    assert [(one["owner"], one["id"]) for one in page["items"] + rest["items"]] == [("ann", "hq"), ("bob", "hq")]
    assert rest["next"] is None


async def test_a_map_that_the_owner_may_not_read_is_refused_to_an_administrator_too(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    bob, admin = await log_in("bob") | JSON, await log_in("admin") | JSON
    await put(client, bob, {"floors": [{"name": "L1", "map": "m1"}]})
    answer = await put(client, admin, path="/v1/buildings/bob:hq")
    assert problem_of(answer, 422, "invalid-building")["detail"].endswith(
        "map 'm2' is not shared with 'bob', its owner"
    )


async def test_its_layout_is_that_of_the_zones_of_its_maps(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    await put(client, ann)
    found = (await client.get(f"{HQ}/layout", headers=ann)).json()
    assert [(floor["name"], floor["map"], floor["elevation"]) for floor in found["floors"]] == [
        ("L1", "m1", 0.0),
        ("L2", "m2", 4.0),
    ]
    first, second = found["lifts"]["north"]
    assert (first["floor"], first["door"], second["floor"]) == ("L1", "north door", "L2")
    assert first["car"] == pytest.approx([-0.97, -1.97, 1.5708], abs=1e-4)
    assert first["wait"] == pytest.approx([-0.97, -1.04, -1.5708], abs=1e-4)
    assert found["doors"][0] == {
        "floor": "L1", "door": "north door", "ends": [[-0.99, -1.94], [-0.95, -1.94]], "lift": "north",
    }  # fmt: skip
    assert [(dock["floor"], dock["dock"], dock["place"]) for dock in found["docks"]] == [
        ("L1", "charger", [-0.9, -1.9, 1.5]),
        ("L2", "charger", [-0.9, -1.9, 1.5]),
    ]
    assert (found["version"], found["ways"], found["warnings"]) == (1, {}, [])


async def test_floors_whose_map_is_removed_or_not_readable_have_no_places(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    await put(client, ann)
    await client.patch(HQ, headers=ann, content=b'{"readers": ["bob"]}')
    bob = await log_in("bob")
    unread = "floor 'L2': there is no map 'm2' that you may read; it has no places"
    found = (await client.get("/v1/buildings/ann:hq/layout", headers=bob)).json()
    assert (found["warnings"][0], found["lifts"]) == (unread, {})
    assert "lift 'north' stops on one floor only: robots do not take it" in found["warnings"]
    assert {door["floor"] for door in found["doors"]} == {"L1"}
    assert (await client.delete("/v1/maps/m2", headers=ann)).status_code == 204
    assert unread in (await client.get(f"{HQ}/layout", headers=ann)).json()["warnings"]
    answer = await put(client, ann, TWO | {"lifts": []})
    assert (answer.status_code, answer.json()["version"]) == (200, 2), "other changes of it are still possible"
    assert unread in answer.json()["warnings"]


async def test_a_check_changes_nothing(client: httpx.AsyncClient, ann: dict[str, str], services: Services) -> None:
    body = TWO | {"floors": [*TWO["floors"][:1], {"name": "L2", "map": "m2", "anchor": [3.0, 0.0, 0.0]}]}
    answer = await client.post(f"{HQ}/check", headers=ann, content=json.dumps(body))
    [warning] = answer.json().pop("warnings")
    assert "its car on floor 'L2' is 3.00 m from where it is on 'L1'" in warning
    counts = {name: answer.json()[name] for name in ("floors", "lifts", "ways", "doors", "docks")}
    assert counts == {"floors": 2, "lifts": 1, "ways": 0, "doors": 2, "docks": 2}
    assert services.store.buildings("ann") == []
    assert list(services.audit.read(AuditQuery(action="check_building"))) == []


async def test_a_user_may_have_some_buildings(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(buildings, "MOST_BUILDINGS", 1)
    services.store.put_building(stored_building("home"))
    problem_of(await put(client, ann), 429, "quota-exceeded")
    assert (await put(client, ann, path="/v1/buildings/home")).status_code == 200


@pytest.mark.parametrize("address", ["-x", "a:b:c", "ann:"])
async def test_an_address_that_is_not_valid_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], address: str
) -> None:
    detail = problem_of(await client.get(f"/v1/buildings/{address}", headers=ann), 422, "invalid-request")["detail"]
    assert "is not a valid address of a building" in detail

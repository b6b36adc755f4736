"""Zones of maps over REST: put, read, kept by other versions, restored and removed."""

import json
from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from ppaas.zones.reading import zones_of
from storage.records import Publication
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, pgm
from tests.unit.endpoints.conftest import LogIn, Publish

ZONES = "/v1/maps/house/zones"
GEOJSON = {"Content-Type": "application/geo+json"}
NONE: dict[str, Any] = {"type": "FeatureCollection", "features": [], "time_zone": "UTC"}


def square(x: float = -0.95, y: float = -1.95, size: float = 0.1) -> dict[str, Any]:
    """Return an area on the map of 4 × 3 cells of 5 cm, whose corner is at (-1, -2)."""
    ring = [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]
    return {"type": "Polygon", "coordinates": [ring]}


def zone(name: str = "stairs", kind: str = "keep_out", geometry: Any = None, **fields: Any) -> dict[str, Any]:
    properties = {"name": name, "kind": kind} | fields
    return {"type": "Feature", "geometry": geometry or square(), "properties": properties}


def collection(*zones: dict[str, Any], **members: Any) -> bytes:
    return json.dumps({"type": "FeatureCollection", "features": list(zones)} | members).encode()


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Publish ann's map, which bob may read."""
    headers = await log_in("ann")
    await publish(headers, readers="bob")
    return headers | GEOJSON


async def put(client: httpx.AsyncClient, headers: dict[str, str], *zones: dict[str, Any], **query: str) -> Any:
    answer = await client.put(ZONES, headers=headers, content=collection(*zones), params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


async def names(client: httpx.AsyncClient, headers: dict[str, str], path: str = ZONES) -> list[str]:
    found = (await client.get(path, headers=headers)).json()
    return [feature["properties"]["name"] for feature in found["features"]]


async def versions(client: httpx.AsyncClient, headers: dict[str, str]) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = (await client.get("/v1/maps/house/versions", headers=headers)).json()["items"]
    return items


async def test_a_map_without_zones_has_an_empty_collection(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    answer = await client.get(ZONES, headers=ann)
    assert (answer.status_code, answer.headers["content-type"]) == (200, "application/geo+json")
    assert answer.json() == NONE | {"in_force": []}
    version = (await client.get("/v1/maps/house", headers=ann)).json()["version"]
    assert answer.headers["etag"] == f'"{version}"'
    assert (await client.get(f"/v1/maps/house/versions/{version}/zones", headers=ann)).json() == NONE


@pytest.mark.parametrize("kind", ["application/geo+json", "application/json; charset=utf-8"])
async def test_zones_are_published_as_a_version_with_the_other_files(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud, kind: str
) -> None:
    body = collection(zone(), zone("dock", "capacity", robots=2), time_zone="Europe/Berlin", bbox=[0, 0, 1, 1])
    answer = await client.put(f"{ZONES}?message=stairs", headers=ann | {"Content-Type": kind}, content=body)
    head = answer.json()
    assert (head["parts"], head["message"], head["author"]) == (["image", "yaml", "zones"], "stairs", "ann")
    assert cloud.changed_maps[-1] == ("house", head["version"])
    got = await client.get(ZONES, headers=ann)
    assert zones_of(got.content) == zones_of(body)
    assert got.json()["in_force"] == ["stairs", "dock"]
    assert got.headers["etag"] == f'"{head["version"]}"'
    assert (await client.get("/v1/maps/house/image", headers=ann)).content == pgm()
    (event,) = services.audit.read(AuditQuery(action="put_zones"))
    assert (event.object, event.details) == ("maps/house", {"version": head["version"], "zones": 2})


async def test_zones_at_other_times_are_not_in_force(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    await put(client, ann, zone(times=[{"until": "2001-01-01T00:00:00"}]), zone("dock", times=[{"from": "00:00"}]))
    assert (await client.get(ZONES, headers=ann)).json()["in_force"] == ["dock"]


async def test_equal_zones_add_no_version(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    first = await put(client, ann, zone(times=[], title="drawn by hand"))
    assert (await put(client, ann, zone()))["version"] == first["version"]
    read = (await client.get(ZONES, headers=ann)).content
    assert (await client.put(ZONES, headers=ann, content=read)).json()["version"] == first["version"]
    assert len(await versions(client, ann)) == 2


async def test_the_zones_of_each_version_are_read_and_come_back_with_it(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    first = await put(client, ann, zone())
    second = await put(client, ann, zone("dock"))
    for head, name in ((first, "stairs"), (second, "dock")):
        path = f"/v1/maps/house/versions/{head['version']}/zones"
        assert await names(client, ann, path) == [name]
        assert "in_force" not in (await client.get(path, headers=ann)).json()
    await client.post("/v1/maps/house/roll_back", headers=ann, json={"version": first["version"]})
    assert await names(client, ann) == ["stairs"]


async def test_a_difference_says_what_became_of_the_zones(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    old = (await client.get("/v1/maps/house", headers=ann)).json()["version"]
    new = (await put(client, ann, zone()))["version"]
    other = (await put(client, ann, zone("dock")))["version"]
    for pair, fate in (((old, new), "added"), ((new, other), "changed"), ((new, old), "removed"), ((new, new), "same")):
        query = dict(zip(("old", "new"), pair, strict=True))
        found = (await client.get("/v1/maps/house/difference", headers=ann, params=query)).json()
        assert (found["changed"], found["octomap"], found["zones"]) == (0, "none", fate)


async def test_a_version_without_zones_keeps_those_of_the_map(
    client: httpx.AsyncClient, ann: dict[str, str], publish: Publish
) -> None:
    await put(client, ann, zone())
    headers = {"Authorization": ann["Authorization"]}
    assert (await publish(headers, image=pgm(value=0))).json()["parts"] == ["image", "yaml", "zones"]
    assert await names(client, ann) == ["stairs"]
    assert (await publish(headers, image=pgm(value=0))).status_code == 201
    assert len(await versions(client, ann)) == 3


async def upload(client: httpx.AsyncClient, ann: dict[str, str], zones: bytes, **more: bytes) -> httpx.Response:
    files = {"yaml": ("house.yaml", YAML), "image": ("house.pgm", pgm(value=205)), "zones": ("z.geojson", zones)}
    headers = {"Authorization": ann["Authorization"]}
    return await client.post("/v1/maps", headers=headers, data={"id": "house"}, files=files | more)


async def test_zones_are_published_with_the_grid(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    await put(client, ann, zone())
    assert (await upload(client, ann, collection(zone("dock")))).json()["parts"] == ["image", "yaml", "zones"]
    assert await names(client, ann) == ["dock"]
    assert (await upload(client, ann, collection())).json()["parts"] == ["image", "yaml"]
    assert await names(client, ann) == []


async def test_a_form_with_wrong_zones_is_refused(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    problem_of(await upload(client, ann, b"{"), 422, "invalid-zones")
    assert "is not on the map" in problem_of(await upload(client, ann, OUTSIDE), 422, "invalid-zones")["detail"]
    files = {"octomap": ("house.bt", b"..."), "zones": ("z.geojson", collection(zone()))}
    headers = {"Authorization": ann["Authorization"]}
    alone = await client.post("/v1/maps", headers=headers, data={"id": "tree"}, files=files)
    assert "'zones' need the grid" in problem_of(alone, 422, "invalid-parameter")["detail"]
    assert len(await versions(client, ann)) == 1


async def test_a_proposal_keeps_zones_that_change_before_its_approval(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn, publish: Publish
) -> None:
    await put(client, ann, zone())
    bob = await log_in("bob")
    review = (await publish(bob, image=pgm(value=0), review="true")).json()
    assert review["parts"] == ["image", "yaml", "zones"]
    await put(client, ann, zone("dock"))
    path = f"/v1/maps/house/reviews/{review['number']}"
    assert not (await client.get(path, headers=bob)).json()["outdated"]
    assert (await client.post(f"{path}/approve", headers=ann, json={})).status_code == 200
    assert await names(client, bob) == ["dock"]
    assert (await client.get("/v1/maps/house/image", headers=ann)).content == pgm(value=0)


async def test_zones_are_removed(client: httpx.AsyncClient, ann: dict[str, str], services: Services) -> None:
    first = (await client.get("/v1/maps/house", headers=ann)).json()["version"]
    problem_of(await client.delete(ZONES, headers=ann), 404, "not-found")
    await put(client, ann, zone())
    removed = await client.delete(f"{ZONES}?message=rebuilt", headers=ann)
    assert (removed.status_code, removed.content) == (204, b"")
    (latest, *_) = await versions(client, ann)
    assert (latest["version"], latest["parts"], latest["message"]) == (first, ["image", "yaml"], "rebuilt")
    events = services.audit.read(AuditQuery(action="remove_zones"))
    assert sorted(event.outcome for event in events) == ["ok", "refused"]
    await put(client, ann, zone())
    assert (await put(client, ann))["version"] == first


async def test_another_version_than_if_match_changes_nothing(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    etag = (await client.get(ZONES, headers=ann)).headers["etag"]
    first = ann | {"If-Match": etag}
    await put(client, first, zone())
    problem_of(await client.put(ZONES, headers=first, content=collection(zone("dock"))), 409, "conflict")
    problem_of(await client.delete(ZONES, headers=first), 409, "conflict")
    assert await names(client, ann) == ["stairs"]


async def test_readers_read_zones_and_only_the_owner_changes_them(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    head = await put(client, ann, zone())
    bob, eve = await log_in("bob") | GEOJSON, await log_in("eve") | GEOJSON
    paths = (ZONES, f"/v1/maps/house/versions/{head['version']}/zones")
    for path in paths:
        assert await names(client, bob, path) == ["stairs"]
        problem_of(await client.get(path, headers=eve), 404, "not-found")
    for headers, problem in ((bob, (403, "not-permitted")), (eve, (404, "not-found"))):
        problem_of(await client.put(ZONES, headers=headers, content=collection()), *problem)
        problem_of(await client.delete(ZONES, headers=headers), *problem)
    await put(client, await log_in("admin") | GEOJSON, zone("dock"))
    assert (await client.get("/v1/maps/house", headers=ann)).json()["owner"] == "ann"


OUTSIDE = collection(zone(), zone("yard", geometry=square(13.4, 52.5)))


@pytest.mark.parametrize(
    ("body", "text"),
    [
        (b"{", "zones are not valid JSON"),
        (b"[]", "zones must be a FeatureCollection of GeoJSON"),
        (collection(zone(kind="moat")), "moat"),
        (collection(zone(), zone()), "two zones have the name 'stairs'"),
        (OUTSIDE, "zone 'yard' is not on the map: it is at 13.4 to 13.5 m × 52.5 to 52.6 m; are its positions longit"),
    ],
    ids=["not JSON", "a list", "kind", "names", "not on the map"],
)
async def test_wrong_zones_are_refused(client: httpx.AsyncClient, ann: dict[str, str], body: bytes, text: str) -> None:
    answer = await client.put(ZONES, headers=ann, content=body)
    assert text in problem_of(answer, 422, "invalid-zones")["detail"]
    assert len(await versions(client, ann)) == 1


BOW_TIE = [[-0.95, -1.95], [-0.85, -1.85], [-0.85, -1.95], [-0.95, -1.85], [-0.95, -1.95]]
CROSSED = zone("server room", geometry={"type": "Polygon", "coordinates": [BOW_TIE]})


@pytest.mark.parametrize("by", ["put", "check", "upload"])
async def test_a_crossed_outline_is_refused_with_its_place(
    client: httpx.AsyncClient, ann: dict[str, str], by: str
) -> None:
    body = collection(zone(), CROSSED)
    if by == "upload":
        answer = await upload(client, ann, body)
    else:
        ask = client.put(ZONES, headers=ann, content=body) if by == "put" else check(client, ann, body)
        answer = await ask
    problem = problem_of(answer, 422, "invalid-zones")
    assert "zone 'server room': its outline crosses itself at (-0.9, -1.9)" in problem["detail"]
    (fault,) = problem["faults"]
    assert (fault["zone"], fault["place"]) == ("server room", [pytest.approx(-0.9), pytest.approx(-1.9)])
    assert len(await versions(client, ann)) == 1


async def check(client: httpx.AsyncClient, headers: dict[str, str], body: bytes) -> httpx.Response:
    return await client.post(f"{ZONES}/check", headers=headers, content=body)


async def test_what_is_mended_is_in_the_answer(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    turned = {"type": "Polygon", "coordinates": [square()["coordinates"][0][::-1]]}
    body = collection(zone(geometry=turned), zone("lift", "capacity", robots=1.0))
    expected = ["zone 'stairs': the outline was reversed", "zone 'lift': properties of a table are read"]
    for answer in (await check(client, ann, body), await client.put(ZONES, headers=ann, content=body)):
        found = answer.json()["warnings"]
        assert [text for text in found if text.startswith(tuple(expected))] == found
        assert len(found) == len(expected)
    assert (await upload(client, ann, body)).json()["warnings"] == found
    assert await names(client, ann) == ["stairs", "lift"]


async def test_a_check_changes_nothing_and_is_not_audited(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, log_in: LogIn
) -> None:
    bob, eve = await log_in("bob") | GEOJSON, await log_in("eve") | GEOJSON
    assert (await check(client, bob, collection(zone()))).json() == {"zones": 1, "warnings": []}
    problem_of(await check(client, eve, collection(zone())), 404, "not-found")
    assert len(await versions(client, ann)) == 1
    assert list(services.audit.read(AuditQuery(action="check_zones"))) == []


async def test_times_of_another_time_zone_than_those_before_are_told(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    timed = zone(times=[{"from": "09:00", "to": "17:00"}])
    first = collection(timed, time_zone="Europe/Berlin")
    assert (await client.put(ZONES, headers=ann, content=first)).json()["warnings"] == []
    read = (await client.get(ZONES, headers=ann)).json()
    assert read["features"][0]["properties"]["time_zone"] == "Europe/Berlin", "editors keep properties"
    through = collection(*read["features"])
    again = (await client.put(ZONES, headers=ann, content=through)).json()
    assert (again["warnings"], len(await versions(client, ann))) == ([], 2)
    lost = (await client.put(ZONES, headers=ann, content=collection(timed))).json()["warnings"]
    assert lost[0].startswith("zone 'stairs': its times have no time zone, so they are in UTC")
    assert lost[1] == "times are in UTC now; those of the zones that are replaced are in Europe/Berlin"


async def test_a_zone_around_the_map_does_not_touch_it(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    ring, hole = (square(x, x, size)["coordinates"][0] for x, size in ((-50.0, 100.0), (-20.0, 40.0)))
    around = zone("fence", geometry={"type": "Polygon", "coordinates": [ring, hole[::-1]]})
    answer = await client.put(ZONES, headers=ann, content=collection(around))
    assert "zone 'fence' is not on the map" in problem_of(answer, 422, "invalid-zones")["detail"]
    parts = {"type": "MultiPolygon", "coordinates": [square()["coordinates"], square(30.0, 30.0)["coordinates"]]}
    found = (await client.put(ZONES, headers=ann, content=collection(zone(geometry=parts)))).json()["warnings"]
    assert found == ["zone 'stairs': a part at (30.05, 30.05) is not on the map"]


async def test_a_zone_may_reach_beyond_the_map(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    await put(client, ann, zone(geometry=square(-50.0, -50.0, 100.0)), zone("edge", geometry=square(-1.05, -2.05)))
    assert await names(client, ann) == ["stairs", "edge"]


async def test_zones_that_are_too_long_are_refused(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    many = collection(*(zone(f"z{number}") for number in range(500)))
    problem_of(await client.put(ZONES, headers=ann, content=many), 413, "message-too-large")
    answer = await upload(client, ann, collection(zone()) + b" " * (1 << 20))
    problem_of(answer, 413, "message-too-large")


async def test_zones_need_their_content_type(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    answer = await client.put(ZONES, headers=ann | {"Content-Type": "text/plain"}, content=collection())
    assert "application/geo+json" in problem_of(answer, 415, "unsupported-media-type")["detail"]


async def test_a_map_without_a_grid_has_no_zones(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    with services.map_store.stage() as staged:
        staged.add("octomap", [b"a tree"])
        services.map_store.publish(staged, Publication("tree", "ann", 1.0))
    answer = await client.put("/v1/maps/tree/zones", headers=ann, content=collection(zone()))
    assert "has an octomap and no grid" in problem_of(answer, 422, "invalid-map")["detail"]

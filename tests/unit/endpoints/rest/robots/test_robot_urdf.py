"""The URDF of a robot over REST."""

import httpx
import pytest

from endpoints.services.services import Services
from ppaas.errors import NotFound
from tests.support.endpoints.problems import problem_of
from tests.support.world.urdf import example
from tests.unit.endpoints.conftest import LogIn, Publish

XML = {"Content-Type": "application/xml"}
BURGER = example("turtlebot3_burger")
PATH = "/v1/robots/tb1/urdf"
LAUGHS = b'<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot name="&b;"><link name="l"/></robot>'


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Return the headers of a user who has the robot tb1."""
    headers = await log_in("ann")
    await publish(headers)
    await client.put("/v1/robots/tb1", headers=headers, json={"map": "house"})
    return headers


async def test_a_urdf_is_stored_verbatim_and_its_summary_is_shown(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    put = await client.put(PATH, headers=ann | XML, content=BURGER)
    summary = put.json()
    assert (put.status_code, summary["circumscribed_radius"], summary["inscribed_radius"]) == (201, 0.124, 0.038)
    assert summary["sensors"] == [{"link": "base_scan", "kind": "laser", "pose": [-0.032, 0.0, 0.182, 0.0, 0.0, 0.0]}]
    got = await client.get(PATH, headers=ann)
    assert (got.content, got.headers["content-type"]) == (BURGER, "application/xml")
    assert got.headers["content-disposition"] == 'attachment; filename="tb1.urdf"'
    assert (await client.get("/v1/robots/tb1", headers=ann)).json()["urdf"] == summary
    assert (await client.put(PATH, headers=ann | XML, content=BURGER)).status_code == 200
    assert (await client.delete(PATH, headers=ann)).status_code == 204
    problem_of(await client.get(PATH, headers=ann), 404, "not-found")
    assert (await client.get("/v1/robots/tb1", headers=ann)).json()["urdf"] is None


async def test_changing_a_robot_keeps_its_urdf(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    await client.put(PATH, headers=ann | XML, content=BURGER)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house", "cores": 0.5})
    await client.patch("/v1/robots/tb1", headers=ann, json={"description": "new", "properties": {"a": {"b": 1}}})
    changed = await client.patch("/v1/robots/tb1", headers=ann, json={"properties": {"a": {"c": 2, "b": None}}})
    assert (changed.json()["description"], changed.json()["properties"]) == ("new", {"a": {"c": 2}})
    cleared = await client.patch("/v1/robots/tb1", headers=ann, json={"description": None, "properties": None})
    assert (cleared.json()["description"], cleared.json()["properties"]) == ("", {})
    assert (await client.get(PATH, headers=ann)).content == BURGER


async def test_a_urdf_is_private_and_removed_with_its_robot(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    await client.put(PATH, headers=ann | XML, content=BURGER)
    bob = await log_in("bob")
    for answer in (
        await client.get(PATH, headers=bob),
        await client.put(PATH, headers=bob | XML, content=BURGER),
        await client.delete(PATH, headers=bob),
    ):
        problem_of(answer, 404, "not-found")
    await client.delete("/v1/robots/tb1", headers=ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    problem_of(await client.get(PATH, headers=ann), 404, "not-found")


@pytest.mark.parametrize(
    ("content", "status", "slug"),
    [
        (b"", 422, "invalid-urdf"),
        (b"{}", 422, "invalid-urdf"),
        (LAUGHS, 422, "invalid-urdf"),
        (BURGER.decode().encode("utf-16"), 422, "invalid-urdf"),
        (BURGER.replace(b"0.14 0.14 0.143", b"0.14 nan 0.143"), 422, "invalid-urdf"),
        (BURGER.replace(b'child link="base_scan"', b'child link="base_footprint"'), 422, "invalid-urdf"),
        (b"<robot>" + b" " * (1 << 20) + b"</robot>", 413, "message-too-large"),
    ],
)
async def test_invalid_urdfs_are_refused_and_not_stored(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, content: bytes, status: int, slug: str
) -> None:
    problem_of(await client.put(PATH, headers=ann | XML, content=content), status, slug)
    with pytest.raises(NotFound):
        services.store.urdf("ann", "tb1")


@pytest.mark.parametrize("kind", ["application/json", "text/html", ""])
async def test_a_urdf_without_an_xml_content_type_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], kind: str
) -> None:
    answer = await client.put(PATH, headers=ann | {"Content-Type": kind}, content=BURGER)
    problem_of(answer, 415, "unsupported-media-type")

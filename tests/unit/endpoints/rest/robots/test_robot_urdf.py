"""The URDF of a robot over REST, and the check of its clone before that."""

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest

from endpoints.resources.services import Services
from endpoints.robot_checks.clone_checker import CloneChecker
from engine.specs.clone_to_check import CloneToCheck
from ppaas.errors import NotFound, RobotFault, Unavailable
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


URDF = b'<robot name="r"><link name="base_link"><collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>'  # noqa: E501


class FakeChecker:
    """Finds the faults that a test sets, and keeps what it was asked."""

    def __init__(self) -> None:
        self.found: list[RobotFault] = []
        self.error: Exception | None = None
        self.asked: list[CloneToCheck] = []

    async def faults(self, clone: CloneToCheck) -> list[RobotFault]:
        self.asked.append(clone)
        if self.error is not None:
            raise self.error
        return self.found


@pytest.fixture
def checker() -> FakeChecker:
    return FakeChecker()


@pytest.fixture
def services(services: Services, checker: FakeChecker) -> Services:
    return replace(services, clones=checker)  # type: ignore[arg-type]


# Robot files and URDFs that a clone would refuse are refused when they are sent.


async def test_all_faults_are_listed_with_their_parameters(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, checker: FakeChecker
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    checker.found = [RobotFault("model", "unknown robot model 'x'; known: y"), RobotFault("parameters.dwa.a", "no a")]
    answer = await client.put("/v1/robots/tb1", headers=ann, json={"map": "house", "model": "x"})
    body = problem_of(answer, 422, "invalid-robot")
    assert body["faults"] == [fault._asdict() for fault in checker.found]
    assert body["detail"] == (
        "correct or remove each of 2: (1) model: unknown robot model 'x'; known: y; (2) parameters.dwa.a: no a"
    )
    problem_of(await client.get("/v1/robots/tb1", headers=ann), 404, "not-found")
    [asked] = checker.asked
    assert (asked.robot.model, asked.resolution) == ("x", pytest.approx(0.05))


async def test_masks_and_a_map_to_continue_that_do_not_exist_are_listed_too(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, checker: FakeChecker
) -> None:
    ann = await log_in("ann")
    checker.found = [RobotFault("model", "unknown robot model 'x'")]
    file = {"map": "new:office", "parameters": {"grid_slam": {"map_file_name": "gone"}}}
    body = problem_of(await client.put("/v1/robots/tb1", headers=ann, json=file), 422, "invalid-robot")
    texts = [fault["text"] for fault in body["faults"]]
    assert texts[0].startswith("map_file_name: 'gone' is not a published map") and texts[1:] == [checker.found[0].text]


async def test_a_change_and_a_urdf_are_checked_and_an_unrelated_change_is_not(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, checker: FakeChecker
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    checker.found = [RobotFault("parameters.dwa.a", "no a")]
    changed = await client.patch("/v1/robots/tb1", headers=ann, json={"parameters": {"dwa": {"a": 1}}})
    problem_of(changed, 422, "invalid-robot")
    xml = ann | {"Content-Type": "application/xml"}
    problem_of(await client.put("/v1/robots/tb1/urdf", headers=xml, content=URDF), 422, "invalid-robot")
    assert checker.asked[-1].robot.urdf is not None
    described = await client.patch("/v1/robots/tb1", headers=ann, json={"description": "old"})
    assert described.json()["description"] == "old"


async def test_a_check_that_is_not_possible_is_a_503(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, checker: FakeChecker
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    checker.error = Unavailable("the process that checks robot files exited: try again")
    problem_of(await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"}), 503, "unavailable")


async def test_an_administrator_has_no_robot_on_a_map_that_is_not_shared_with_it(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, admin = await log_in("ann"), await log_in("admin")
    await publish(ann)
    answer = await client.put("/v1/robots/tb1", headers=admin, json={"map": "house"})
    problem = problem_of(answer, 422, "invalid-parameter")
    assert problem["detail"] == "map 'house' is not shared with 'admin', to whom the robot belongs"
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 201
    assert (await client.put("/v1/robots/ann:tb1", headers=admin, json={"map": "house"})).status_code == 200


class TestByTheRealProcess:
    """With the process that endpoints start."""

    @pytest.fixture
    async def services(self, services: Services, tmp_path: Path) -> AsyncIterator[Services]:
        checker = CloneChecker(tmp_path, seconds=600.0)
        yield replace(services, clones=checker)
        await checker.close()

    async def test_a_file_is_stored_once_its_faults_are_corrected(
        self, client: httpx.AsyncClient, log_in: LogIn, publish: Publish
    ) -> None:
        ann = await log_in("ann")
        await publish(ann)
        file: dict[str, Any] = {
            "map": "house",
            "base_local_planner": "dwaa",
            "parameters": {"amcl": {"min_particles": "many"}, "lattice": {}},
        }
        body = problem_of(await client.put("/v1/robots/tb1", headers=ann, json=file), 422, "invalid-robot")
        assert [fault["parameter"] for fault in body["faults"]] == [
            "parameters.amcl.min_particles", "base_local_planner",
        ]  # fmt: skip
        assert "known: dwa, mppi, pure_pursuit" in body["faults"][1]["text"]
        file |= {"base_local_planner": "dwa", "parameters": {"amcl": {"min_particles": 100}, "lattice": {}}}
        assert (await client.put("/v1/robots/tb1", headers=ann, json=file)).status_code == 201

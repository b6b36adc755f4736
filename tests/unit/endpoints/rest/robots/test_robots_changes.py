"""Changes of robots, by JSON merge patch."""

from typing import Any

import httpx
import pytest

from endpoints.services.services import Services
from ppaas.errors import Conflict
from storage.records import RobotRecord
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import robot
from tests.unit.endpoints.conftest import LogIn, Publish

MERGE = {"Content-Type": "application/merge-patch+json"}


FILE = {"map": "house", "cores": 0.25, "parameters": {"amcl": {"max_particles": 800, "min_particles": 100}}}


async def test_a_patch_changes_only_the_given_fields_of_a_robot(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).json()
    assert (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).status_code == 200
    patch = '{"cores": 2, "initial_pose": [1, 2], "parameters": {"amcl": {"min_particles": null}, "move_base": {}}}'
    changed = await client.patch("/v1/robots/tb1", headers=ann | MERGE, content=patch)
    parameters = {"amcl": {"max_particles": 800}, "move_base": {}}
    assert changed.json() == made | {"cores": 2.0, "initial_pose": [1.0, 2.0, 0.0], "parameters": parameters}
    reset = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": None, "parameters": None})
    assert (reset.json()["cores"], reset.json()["parameters"]) == (1.0, {})


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"map": None}, "map"),
        ({"cores": 0}, "cores"),
        ({"colour": "red"}, "colour"),
        ({"initial_pose": [1]}, "initial_pose"),
        ({"parameters": 1}, "parameters"),
        ({"model": "../x"}, "model"),
    ],
)
async def test_an_invalid_patch_is_refused_and_the_robot_stays(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any], where: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).json()
    answer = await client.patch("/v1/robots/tb1", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", where]
    assert (await client.get("/v1/robots/tb1", headers=ann)).json() == made | {"urdf": None}


async def test_traffic_is_read_into_the_parameters(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann, amcl = await log_in("ann"), {"amcl": {"max_particles": 800, "min_particles": 100}}
    await publish(ann)

    async def put(traffic: object) -> object:
        answer = await client.put("/v1/robots/tb1", headers=ann, json=FILE | {"traffic": traffic})
        return answer.json()["parameters"]

    async def patch(change: dict[str, Any]) -> object:
        return (await client.patch("/v1/robots/tb1", headers=ann, json=change)).json()["parameters"]

    assert await put(True) == amcl | {"traffic": {}}
    assert await put({"spacing": 0.6}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await put(False) == await put(None) == amcl
    assert await patch({"traffic": {"spacing": 0.6}}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await patch({"cores": 0.5}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await patch({"traffic": True}) == amcl | {"traffic": {"spacing": 0.6}}, "its parameters stay"
    assert await patch({"traffic": None}) == amcl
    assert await patch({"parameters": None, "traffic": True}) == {"traffic": {}}
    assert await patch({"traffic": False}) == {}
    for wrong in (1, "yes", []):
        answer = await client.put("/v1/robots/tb1", headers=ann, json=FILE | {"traffic": wrong})
        assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", "traffic"]


async def test_a_robot_is_not_moved_to_a_map_without_read_access(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann)
    await publish(bob, "secret")
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    problem_of(await client.patch("/v1/robots/tb1", headers=ann, json={"map": "secret"}), 404, "not-found")
    problem_of(await client.patch("/v1/robots/tb9", headers=ann, json={"cores": 1}), 404, "not-found")


async def test_a_concurrent_change_of_a_robot_is_a_conflict(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    put = services.store.put_robot

    def late(record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        put(robot("tb1", cores=3.0))
        return put(record, instead_of=instead_of)

    monkeypatch.setattr(services.store, "put_robot", late)
    answer = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": 2})
    problem_of(answer, 409, Conflict.slug)
    assert services.store.robot("ann", "tb1").cores == 3.0

"""Machines over REST, for administrators."""

from typing import Any

import httpx
import pytest

from engine.specs.machine_settings import MachineSettings
from tests.support.endpoints.fake_cloud import FakeCloud, endpoint
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn

M1 = "/v1/machines/m1"


@pytest.fixture
async def admin(log_in: LogIn) -> dict[str, str]:
    return await log_in("admin")


async def test_a_machine_is_shown_with_capacity_usage_and_settings(client: httpx.AsyncClient, admin: Any) -> None:
    shown = (await client.get(M1, headers=admin)).json()
    assert shown == (await client.get("/v1/machines", headers=admin)).json()["items"][0]
    expected = {"id": "m1", "state": "ready", "cores": 4, "capacity": 16.0, "given": 1.0, "containers": 1, "load": 0.5}
    expected |= {"memory": 8 << 30, "memory_given": 128 << 20, "memory_used": 1 << 30, "labels": {}}
    expected |= {"max_containers": 100, "max_memory": None, "oversubscription": 4.0, "draining": False}
    assert expected.items() <= shown.items()
    unknown = await client.get("/v1/machines/m2", headers=admin)
    assert "known: m1" in problem_of(unknown, 404, "not-found")["detail"]


@pytest.mark.parametrize(
    ("method", "path"), [("GET", M1), ("PATCH", M1), ("DELETE", M1), ("POST", f"{M1}/admit"), ("GET", "/v1/machines")]
)
async def test_only_administrators_see_and_change_machines(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud, method: str, path: str
) -> None:
    body = {"json": {"draining": True}} if method == "PATCH" else {}
    problem_of(await client.request(method, path, headers=await log_in("ann"), **body), 403, "not-permitted")
    assert cloud.known["m1"].settings == MachineSettings()


async def test_omitted_settings_stay_and_null_restores_the_default(
    client: httpx.AsyncClient, admin: Any, cloud: FakeCloud
) -> None:
    change = {"labels": {"zone": "a", "gpu": "yes"}, "max_containers": 3, "max_memory": 1 << 30}
    changed = (await client.patch(M1, json=change, headers=admin)).json()
    assert (changed["labels"], changed["max_containers"], changed["capacity"]) == (change["labels"], 3, 8.0)
    await client.patch(M1, json={"labels": {"gpu": None}, "max_memory": None}, headers=admin)
    assert cloud.known["m1"].settings == MachineSettings({"zone": "a"}, max_containers=3)
    changed = (await client.patch(M1, json={"draining": True, "labels": None}, headers=admin)).json()
    assert (changed["state"], changed["labels"]) == ("draining", {})
    assert cloud.known["m1"].settings == MachineSettings(max_containers=3, draining=True)


@pytest.mark.parametrize(
    "change",
    [
        {"max_containers": -1},
        {"max_containers": 1.5},
        {"max_memory": 0},
        {"oversubscription": 0},
        {"oversubscription": "4"},
        {"draining": "yes"},
        {"labels": {"a b": "c"}},
        {"labels": {"zone": ""}},
        {"labels": {f"l{number}": "x" for number in range(33)}},
        {"cores": 64},
    ],
    ids=str,
)
async def test_invalid_machine_settings_change_nothing(
    client: httpx.AsyncClient, admin: Any, cloud: FakeCloud, change: dict[str, Any]
) -> None:
    problem_of(await client.patch(M1, json=change, headers=admin), 422, "invalid-request")
    assert cloud.known["m1"].settings == MachineSettings()


async def test_a_machine_with_containers_is_removed_only_by_force(
    client: httpx.AsyncClient, admin: Any, cloud: FakeCloud
) -> None:
    problem_of(await client.delete(M1, headers=admin), 409, "conflict")
    assert (await client.delete(M1, params={"force": True}, headers=admin)).status_code == 204
    for answer in (
        await client.get(M1, headers=admin),
        await client.delete(M1, headers=admin),
        await client.patch(M1, json={}, headers=admin),
    ):
        problem_of(answer, 404, "not-found")
    assert (await client.post(f"{M1}/admit", headers=admin)).json() == {"id": "m1"}
    assert list(cloud.known) == ["m1"]


# Endpoints over REST, for administrators.


async def test_endpoints_are_listed_by_id_in_pages(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> None:
    cloud.serving = [endpoint("hall-1", state="silent"), endpoint("local-2"), endpoint("local-1")]
    admin = await log_in("admin")
    first = (await client.get("/v1/endpoints", params={"limit": 2}, headers=admin)).json()
    rest = (await client.get("/v1/endpoints", params={"limit": 2, "cursor": first["next"]}, headers=admin)).json()
    assert [one["id"] for one in (*first["items"], *rest["items"])] == ["hall-1", "local-1", "local-2"]
    assert (rest["next"], first["items"][0]["state"]) == (None, "silent")


async def test_an_endpoint_is_shown_with_its_load(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> None:
    admin = await log_in("admin")
    shown = (await client.get("/v1/endpoints/local-1", headers=admin)).json()
    assert shown == {
        "id": "local-1", "machine": "m1", "pid": 4711, "url": "http://127.0.0.1:8500", "release": "0.2.0",
        "state": "ready", "sockets": 3, "frames": 60.0, "cpu": 0.25, "memory": 90 << 20, "protocol": 1,
    }  # fmt: skip
    cloud.serving.clear()
    problem_of(await client.get("/v1/endpoints/local-1", headers=admin), 404, "not-found")


@pytest.mark.parametrize("path", ["/v1/endpoints", "/v1/endpoints/local-1"])
async def test_only_administrators_see_endpoints(client: httpx.AsyncClient, log_in: LogIn, path: str) -> None:
    problem_of(await client.get(path, headers=await log_in("ann")), 403, "not-permitted")
    problem_of(await client.get(path), 401, "not-authenticated")

"""Health of the cloud over REST."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import msgspec
import pytest

from endpoints.resources.services import Services
from endpoints.resources.store_health import StoreHealthCheck
from engine.leadership.leadership import MASTER
from engine.specs.start_state import READY, KernelProgress, StartState
from ppaas import __version__
from ppaas.clock import ManualClock, epoch
from ppaas.errors import Unavailable
from storage.disk_space import DiskReserve
from storage.memory.store import MemoryStore
from storage.urls.opening import open_map_store
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn


def unreachable(*_arguments: Any, **_options: Any) -> None:
    raise Unavailable("db:9042: no node answers")


async def test_health_is_public_and_reports_ok(client: httpx.AsyncClient) -> None:
    answer = await client.get("/v1/health")
    assert answer.status_code == 200
    fine = {"state": "ok", "reason": None}
    stores = {"store": fine, "map_store": fine, "audit": fine}
    cloud = {"endpoint": "", "master": "ok", "leader": None, "kernels": None}
    said = answer.json()
    assert abs(said.pop("time") - epoch()) < 60.0
    assert said == {"status": "ok", "version": __version__, **stores, **cloud, "plans_waiting": 0, "disk": None}


async def test_a_full_disk_degrades_the_cloud_and_only_administrators_see_why(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, tmp_path: Path
) -> None:
    reserve = DiskReserve(tmp_path)
    object.__setattr__(services, "disk", reserve)
    headers = {role: await log_in(role) for role in ("admin", "user")}
    reserve.keep()
    assert (await client.get("/v1/health")).json()["status"] == "ok"
    reserve.release()  # as when the disk is full
    for role, bearer in headers.items():
        report = (await client.get("/v1/health", headers=bearer)).json()
        assert report["status"] == "degraded"
        if role == "admin":
            assert report["disk"]["state"] == "full"
            assert "nothing new is stored" in report["disk"]["reason"]
            assert 0 < report["disk"]["free"] <= report["disk"]["total"]
        else:
            assert report["disk"] is None


async def test_only_administrators_see_why_a_store_is_unreachable(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    headers = {role: await log_in(role) for role in ("admin", "user")}
    monkeypatch.setattr(services.store, "users", unreachable)
    for role, reason in (("admin", "db:9042: no node answers"), ("user", None)):
        report = (await client.get("/v1/health", headers=headers[role])).json()
        assert report["status"] == "degraded"
        assert report["store"] == {"state": "away", "reason": reason}
        assert report["map_store"]["state"] == "ok"


async def test_an_audit_log_that_cannot_be_written_degrades_the_cloud(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    headers = await log_in("admin")
    object.__setattr__(services.audit, "fault", "the disk is full")
    assert (await client.get("/v1/health")).json()["audit"] == {"state": "away", "reason": None}
    report = (await client.get("/v1/health", headers=headers)).json()
    assert report["status"] == "degraded"
    assert report["audit"] == {"state": "away", "reason": "the disk is full"}


@pytest.mark.parametrize(("silence", "status", "master"), [(2.9, "ok", "ok"), (3.1, "degraded", "away")])
async def test_a_silent_master_degrades_the_cloud(
    client: httpx.AsyncClient, cloud: FakeCloud, services: Services, silence: float, status: str, master: str
) -> None:
    object.__setattr__(services, "endpoint", "local-2")
    cloud.master_silence = silence
    report = (await client.get("/v1/health")).json()
    assert (report["status"], report["master"], report["endpoint"]) == (status, master, "local-2")


async def test_only_administrators_see_which_process_leads(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    none = services.store.lease(MASTER)
    services.store.change_lease(msgspec.structs.replace(none, holder="hall:/srv#1", epoch=7), instead_of=none)
    admin, user = [(await client.get("/v1/health", headers=await log_in(name))).json() for name in ("admin", "ann")]
    assert (admin["leader"], user["leader"]) == ({"holder": "hall:/srv#1", "epoch": 7}, None)


@pytest.mark.parametrize("silence", [10.1, float("inf")], ids=["lost", "never found"])
async def test_an_endpoint_without_a_master_is_not_ready(
    client: httpx.AsyncClient, cloud: FakeCloud, silence: float
) -> None:
    assert (await client.get("/v1/health/ready")).json() == {"ready": True}
    cloud.master_silence = silence
    answer = await client.get("/v1/health/ready")
    assert "no master" in problem_of(answer, 503, "unavailable")["detail"]
    cloud.master_silence = 9.9
    assert (await client.get("/v1/health/ready")).status_code == 200


@pytest.mark.parametrize(("kind", "query"), [("store", "users"), ("map_store", "maps")])
async def test_an_endpoint_is_ready_once_both_stores_have_answered(
    client: httpx.AsyncClient, services: Services, clock: ManualClock, kind: str, query: str
) -> None:
    object.__setattr__(services, "health", StoreHealthCheck(clock))
    with pytest.MonkeyPatch.context() as away:
        away.setattr(getattr(services, kind), query, unreachable)
        problem_of(await client.get("/v1/health/ready"), 503, "unavailable")
    clock.advance(3.0)
    assert (await client.get("/v1/health/ready")).status_code == 200
    with pytest.MonkeyPatch.context() as away:
        away.setattr(getattr(services, kind), query, unreachable)
        clock.advance(3.0)
        assert (await client.get("/v1/health")).json()["status"] == "degraded"
        assert (await client.get("/v1/health/ready")).status_code == 200


async def test_a_store_that_does_not_answer_in_time_is_reported() -> None:
    answer = threading.Event()

    class Frozen(MemoryStore):
        def users(self, **_options: Any) -> Any:
            answer.wait(10.0)
            return []

    store, _ = await StoreHealthCheck(patience=0.05).stores(Frozen(), open_map_store("memory:"))
    answer.set()
    assert not store.answers
    assert "no answer within 0.05 s" in str(store.reason)


async def test_store_health_is_cached_between_requests() -> None:
    asked, now = [], [0.0]

    class Counting(MemoryStore):
        def users(self, **options: Any) -> Any:
            asked.append(now[0])
            return super().users(**options)

    clock: Callable[[], float] = lambda: now[0]  # noqa: E731
    health, store = StoreHealthCheck(clock), Counting()
    for now[0] in (0.0, 1.0, 3.0, 4.0):
        await health.stores(store, open_map_store("memory:"))
    assert asked == [0.0, 3.0]


async def test_a_cloud_that_cannot_start_containers_is_starting_and_not_ready(
    client: httpx.AsyncClient, cloud: FakeCloud
) -> None:
    cloud.start = StartState(ready=False, machines={"m1": KernelProgress(12, 107, ("lattice/driving",))})
    report = (await client.get("/v1/health")).json()
    assert report["status"] == "starting"
    assert report["kernels"] == {"done": 12, "total": 107, "compiling": ["lattice/driving"]}
    answer = await client.get("/v1/health/ready")
    assert "compiling kernels, 12 of 107" in problem_of(answer, 503, "starting")["detail"]
    assert int(answer.headers["Retry-After"]) > 1


async def test_a_cloud_that_compiles_kernels_of_further_planners_is_ready(
    client: httpx.AsyncClient, cloud: FakeCloud
) -> None:
    cloud.start = StartState(machines={"m1": KernelProgress(40, 107)})
    report = (await client.get("/v1/health")).json()
    assert (report["status"], report["kernels"]["done"]) == ("ok", 40)
    assert (await client.get("/v1/health/ready")).status_code == 200
    cloud.start = READY
    assert (await client.get("/v1/health")).json()["kernels"] is None

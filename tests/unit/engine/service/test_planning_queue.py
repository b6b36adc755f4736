"""Tests of queued path requests."""

from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.quotas import Quota, Quotas
from engine.service import planning_places
from engine.service.endpoints.cloud import Cloud
from engine.service.master_driver import MasterDriver
from engine.service.planning.planning import Planning
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion
from ppaas.errors import Queued, QuotaExceeded, Unavailable
from ppaas.plans.path_service import PathRequest
from storage.memory.store import MemoryStore
from tests.support.engine.specs import robot_request
from tests.support.waiting import until

MAP = MapVersion("house", "v")
KEY = "planning:ann/house@v"


def path(*, queue: bool) -> PathRequest:
    return PathRequest((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), queue=queue)


@pytest.fixture
def quotas() -> Quotas:
    return Quotas(Quota(containers=1))


@pytest.fixture
async def service(tmp_path: Path, quotas: Quotas) -> AsyncIterator[MasterDriver]:
    """Return the driver of a cloud in which user ann has used up the quota of one container."""
    made = MasterDriver(Master(FirstFit(), quotas), CheckpointSelection(MemoryStore()), tmp_path, "secret")
    await made.start()
    made.open_place(robot_request("tb1"))
    yield made
    await made.close()


@pytest.fixture
def planning(service: MasterDriver, quotas: Quotas) -> Iterator[Planning]:
    made = Cloud(service, quotas)
    yield made.planning
    made.close()


async def test_queued_request_gets_its_position_and_expires(
    service: MasterDriver, planning: Planning, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning_places, "PATIENCE", 0.05)
    for _ in range(2):
        with pytest.raises(Queued) as raised:
            await planning.compute_path("ann", MAP, path(queue=True))
        assert raised.value.position == service.position(KEY) == 1
    await until(lambda: service.position(KEY) is None)
    assert service.place(KEY) is None


async def test_request_without_queueing_is_refused(planning: Planning) -> None:
    with pytest.raises(QuotaExceeded):
        await planning.compute_path("ann", MAP, path(queue=False))
    with pytest.raises(Queued):
        await planning.compute_path("ann", MAP, path(queue=True))
    with pytest.raises(Unavailable, match="position 1 of the queue"):
        await planning.compute_path("ann", MAP, path(queue=False))


async def test_closed_place_admits_a_waiting_request(service: MasterDriver, planning: Planning) -> None:
    with pytest.raises(Queued):
        await planning.compute_path("ann", MAP, path(queue=True))
    await service.close_place("robot:ann/tb1", Unavailable("gone"))
    assert service.position(KEY) is None and KEY in service._master.places

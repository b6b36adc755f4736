"""Path requests while kernels are being compiled."""

import asyncio
import threading
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.control import planning_places
from engine.control.master_calls.cloud import Cloud
from engine.control.master_driver import MasterDriver
from engine.control.planning import planning as module
from engine.control.planning.planning import Planning, PoseUnpacker
from engine.control.robot_sessions import RobotSessions
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.quotas import Quota, Quotas
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion
from engine.specs.start_state import KernelProgress, StartState
from ppaas.errors import MalformedMessage, Queued, QuotaExceeded, Starting, Unavailable
from ppaas.plans.encoding.codes import pack_poses, unpack_poses
from ppaas.plans.path_service import PathRequest
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.engine.specs import robot_request
from tests.support.waiting import until

MAP = MapVersion("house", "v1")
COMPILING = StartState(ready=False, machines={"local": KernelProgress(12, 167, ("field/tile_growth",))})
MISSING = "the kernels of this request are being compiled, 1 of 2 (missing: lattice/hybrid_astar): try again"


class Place:
    """Place of a planning container."""

    container, pid = "c1", 4711

    def __init__(self, late: bool = False) -> None:
        self.late = late

    async def ready(self, timeout: float, why) -> None:
        if self.late:
            raise why() or Unavailable("no container was ready")

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        raise Starting(MISSING)


def planning(place: Place, position: int | None = None, start: StartState = COMPILING) -> Planning:
    async def use(*_: object):
        return place, position

    return Planning(use, lambda: start)  # type: ignore[arg-type]


async def asked(paths: Planning, *, queue: bool) -> None:
    await paths.compute_path("ann", MAP, PathRequest((0.0, 0.0), (1.0, 0.0), queue=queue))


@pytest.mark.parametrize("place", [Place(late=True), Place()])
async def test_a_request_that_may_wait_has_a_position_and_the_progress(place: Place) -> None:
    with pytest.raises(Queued, match=r"position 1 in the queue \(.*kernels.*of \d+.*\): repeat") as queued:
        await asked(planning(place), queue=True)
    assert queued.value.position == 1
    with pytest.raises(Starting, match=r"kernels.*of \d+"):
        await asked(planning(place), queue=False)


async def test_a_request_in_the_queue_of_a_starting_cloud_has_the_progress() -> None:
    with pytest.raises(Queued, match=r"position 3 in the queue \(the cloud is starting: compiling kernels, 12 of 167"):
        await asked(planning(Place(), position=3), queue=True)
    with pytest.raises(Queued, match="position 3 in the queue: repeat"):
        await asked(planning(Place(), position=3, start=module.READY), queue=True)


POSES = np.arange(70.0).reshape(10, 7)


async def test_poses_are_unpacked_before_and_after_the_kernels_are_loaded() -> None:
    unpacker = PoseUnpacker()
    for _ in range(3):
        assert (await unpacker.unpack(pack_poses(POSES))).tobytes() == POSES.tobytes()
    with pytest.raises(MalformedMessage):
        await unpacker.unpack(b"x")


async def test_a_caller_that_gives_up_does_not_end_the_loading_for_others(monkeypatch: pytest.MonkeyPatch) -> None:
    may_load = threading.Event()

    def load() -> module.Unpack:
        may_load.wait()
        return unpack_poses

    monkeypatch.setattr(module, "_load", load)
    unpacker = PoseUnpacker()
    unpacker.begin()
    first, second = (asyncio.create_task(unpacker.unpack(pack_poses(POSES))) for _ in range(2))
    await asyncio.sleep(0)
    first.cancel()
    may_load.set()
    assert (await second).tobytes() == POSES.tobytes()
    assert first.cancelled()


async def test_kernels_that_could_not_be_loaded_are_loaded_at_the_next_path(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> module.Unpack:
        raise OSError("no folder")

    unpacker = PoseUnpacker()
    with monkeypatch.context() as patch:
        patch.setattr(module, "_load", fail)
        with pytest.raises(OSError, match="no folder"):
            await unpacker.unpack(pack_poses(POSES))
    assert (await unpacker.unpack(pack_poses(POSES))).tobytes() == POSES.tobytes()


QUEUED_MAP = MapVersion("house", "v")
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
def planning_of_a_cloud(service: MasterDriver, quotas: Quotas) -> Iterator[Planning]:
    made = Cloud(service, quotas, MemoryStore(), RobotSessions(service, MemoryStore(), MemoryMapStore()))
    yield made.planning
    made.close()


async def test_queued_request_gets_its_position_and_expires(
    service: MasterDriver, planning_of_a_cloud: Planning, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning_places, "PATIENCE", 0.05)
    for _ in range(2):
        with pytest.raises(Queued) as raised:
            await planning_of_a_cloud.compute_path("ann", QUEUED_MAP, path(queue=True))
        assert raised.value.position == service.position(KEY) == 1
    await until(lambda: service.position(KEY) is None)
    assert service.place(KEY) is None


async def test_request_without_queueing_is_refused(planning_of_a_cloud: Planning) -> None:
    with pytest.raises(QuotaExceeded):
        await planning_of_a_cloud.compute_path("ann", QUEUED_MAP, path(queue=False))
    with pytest.raises(Queued):
        await planning_of_a_cloud.compute_path("ann", QUEUED_MAP, path(queue=True))
    with pytest.raises(Unavailable, match="position 1 of the queue"):
        await planning_of_a_cloud.compute_path("ann", QUEUED_MAP, path(queue=False))


async def test_closed_place_admits_a_waiting_request(service: MasterDriver, planning_of_a_cloud: Planning) -> None:
    with pytest.raises(Queued):
        await planning_of_a_cloud.compute_path("ann", QUEUED_MAP, path(queue=True))
    await service.close_place("robot:ann/tb1", Unavailable("gone"))
    assert service.position(KEY) is None and KEY in service._master.places

"""Container gateway of a machine, with valid and misbehaving containers."""

import stat
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from pathlib import Path

import msgspec
import pytest

from engine.agent import store_requests
from engine.agent.container_gateway import MAX_REQUESTS, ContainerGateway
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.versions import Protocols
from engine.specs.checkpoints import marks
from engine.specs.containers import ContainerSpec, MapVersion
from ppaas.errors import NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint, CloneLogChange
from tests.support.engine.attached_container import attach_container
from tests.support.engine.engine_links import dial_gateway, receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import coordinator_spec, planning_spec, robot_spec
from tests.support.storage import records
from tests.support.waiting import until

Stream = FrameStream[machine_link.ToContainer]


class SlowStore(MemoryStore):
    """Store that blocks until the test allows it to continue, and may fail."""

    def __init__(self) -> None:
        super().__init__()
        self.go = threading.Event()
        self.go.set()
        self.error: Exception | None = None

    def save_clone(self, checkpoint: CloneCheckpoint, change: CloneLogChange | None = None) -> None:
        assert self.go.wait(10)
        if self.error is not None:
            raise self.error
        super().save_clone(checkpoint, change)


@pytest.fixture
def store() -> SlowStore:
    return SlowStore()


@pytest.fixture
def fabric() -> FakeFabric:
    return FakeFabric()


@pytest.fixture
async def gateway(tmp_path: Path, store: SlowStore, fabric: FakeFabric) -> AsyncIterator[ContainerGateway]:
    opened = ContainerGateway(tmp_path / "gate.sock", store, fabric, attach_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


Attach = Callable[[ContainerSpec], Awaitable[Stream]]


@pytest.fixture
def attach(gateway: ContainerGateway) -> Attach:
    return partial(attach_container, gateway)


async def ask(
    stream: Stream, request: machine_link.SaveClone | machine_link.KeepPlan | machine_link.PrepareIndex
) -> machine_link.Done:
    """Send a request, and return its answer."""
    stream.write(request)
    answer = await done(stream)
    assert answer.request == request.request
    return answer


async def done(stream: Stream) -> machine_link.Done:
    """Return the next frame, which must be an answer."""
    frame = await receive(stream)
    assert isinstance(frame, machine_link.Done)
    return frame


def slug(done: machine_link.Done) -> str | None:
    return done.refusal.slug if done.refusal is not None else None


async def test_a_coordinator_saves_checkpoints_under_the_name_of_its_map(attach: Attach, store: SlowStore) -> None:
    spec = coordinator_spec()
    stream = await attach(spec)
    assert slug(await ask(stream, machine_link.SaveClone(1, {"people_coordinator": b"7"}))) is None
    saved = store.clone("ann", spec.checkpoint_name)
    assert saved.nodes == {"people_coordinator": b"7"} | marks(spec, "")
    assert coordinator_spec(version=MapVersion("depot", "v1")).checkpoint_name != spec.checkpoint_name
    await stream.close()


# -- notifications -----------------------------------------------------------------------------------------------------


async def test_container_is_notified_of_its_new_size(gateway: ContainerGateway, attach: Attach) -> None:
    stream = await attach(robot_spec("c1"))
    gateway.resized("c2", 4)
    gateway.resized("c1", 2)
    assert await receive(stream) == machine_link.Resized(2)
    await stream.close()
    await until(lambda: gateway._attached == {})
    gateway.resized("c1", 1)


async def test_endpoint_notice_skips_containers_that_are_shut_out(gateway: ContainerGateway, attach: Attach) -> None:
    stays, ends = await attach(robot_spec("c1")), await attach(robot_spec("c2", robot="tb2"))
    gateway.shut_out("c2")
    gateway.endpoint_came()
    gateway.resized("c2", 1)
    assert await receive(stays) == machine_link.EndpointCame()
    assert await receive(ends) == machine_link.Resized(1)


# -- attaching ---------------------------------------------------------------------------------------------------------


async def test_socket_is_accessible_to_its_user_only(gateway: ContainerGateway) -> None:
    assert stat.S_IMODE(gateway.path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "first",
    [
        machine_link.AttachContainer("c1", "wrong"),
        machine_link.AttachContainer("c1", "schlüssel"),
        machine_link.AttachContainer("c2", "secret"),
        machine_link.AttachContainer("c1", "secret", Protocols(8, 9)),
        machine_link.SaveClone(1, {}),
    ],
    ids=["wrong secret", "odd secret", "unknown container", "unknown protocols", "nameless"],
)
async def test_unknown_client_is_disconnected_and_the_expected_one_attaches(
    gateway: ContainerGateway, first: msgspec.Struct, attach: Attach
) -> None:
    gateway.expect(robot_spec("c1"), "secret")
    stranger = await dial_gateway(gateway.path)
    stranger.write(first)
    assert await receive(stranger) is None
    stream = await attach(robot_spec("c1"))
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) is None


async def test_container_attaches_only_once(gateway: ContainerGateway, attach: Attach) -> None:
    first = await attach(robot_spec("c1"))
    second = await dial_gateway(gateway.path)
    second.write(machine_link.AttachContainer("c1", "secret"))
    assert await receive(second) is None
    assert slug(await ask(first, machine_link.SaveClone(1, {}))) is None


async def test_attaching_as_a_second_container_disconnects(gateway: ContainerGateway, attach: Attach) -> None:
    stream, other = await attach(robot_spec("c1")), robot_spec("c2", "bob")
    gateway.expect(other, "secret")
    stream.write(machine_link.AttachContainer("c2", "secret"))
    assert await receive(stream) is None
    assert gateway.awaited == 1


async def test_forgotten_container_cannot_attach(gateway: ContainerGateway) -> None:
    gateway.expect(robot_spec("c1"), "secret")
    gateway.forget("c1")
    stream = await dial_gateway(gateway.path)
    stream.write(machine_link.AttachContainer("c1", "secret"))
    assert await receive(stream) is None


async def test_silent_client_is_disconnected(tmp_path: Path, store: SlowStore, fabric: FakeFabric) -> None:
    gateway = ContainerGateway(tmp_path / "gate.sock", store, fabric, attach_timeout=0.05)
    await gateway.start()
    stream = await dial_gateway(gateway.path)
    assert await receive(stream) is None
    await gateway.close()


async def test_closing_disconnects_attached_and_unattached_clients(gateway: ContainerGateway, attach: Attach) -> None:
    known, silent = await attach(robot_spec("c1")), await dial_gateway(gateway.path)
    await until(lambda: len(gateway._streams) == 2)
    await gateway.close()
    assert await receive(known) is None
    assert await receive(silent) is None
    assert not gateway.path.exists()


# -- the stores --------------------------------------------------------------------------------------------------------


async def test_checkpoint_is_stored_under_the_containers_own_robot(attach: Attach, store: SlowStore) -> None:
    stream = await attach(robot_spec("c1", "ann", "tb1"))
    await attach(robot_spec("c2", "bob", "tb1"))
    nodes = {"amcl": b"{}", "user": b"bob", "../bob/tb1": b"x"}
    assert slug(await ask(stream, machine_link.SaveClone(1, nodes))) is None
    assert store.clone("ann", "tb1").nodes.items() >= nodes.items()
    for user, robot in (("bob", "tb1"), ("ann", "tb2")):
        with pytest.raises(NotFound):
            store.clone(user, robot)


async def test_log_of_a_node_is_stored_with_the_checkpoint_and_read_in_pages(
    attach: Attach, store: SlowStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store_requests, "LOG_BYTES", 100)
    spec = msgspec.structs.replace(robot_spec("c1", "ann", "tb1"), session="c1")
    stream = await attach(spec)
    changes = [
        CloneLogChange("grid_slam", {number: bytes(10) for number in range(40)}),
        CloneLogChange("grid_slam", {40: b"last"}, [3]),
        CloneLogChange("other", {1: b"x"}),
    ]
    assert slug(await ask(stream, machine_link.SaveClone(1, {"grid_slam": b"{}"}, changes))) is None
    numbers: list[int] = []
    while True:
        entries = await read_log(stream, "grid_slam", numbers[-1] if numbers else -1)
        if not entries:
            break
        assert len(entries) <= 16
        numbers += [number for number, _ in entries]
    assert numbers == [number for number in range(41) if number != 3]
    assert store.clone_log("ann", "tb1", "c1/other") == [(1, b"x")]
    again = await attach(msgspec.structs.replace(robot_spec("c2", "ann", "tb1"), session="c1"))
    assert await read_log(again, "other", -1) == [(1, b"x")]


async def read_log(stream: Stream, node: str, after: int) -> list[tuple[int, bytes]]:
    stream.write(machine_link.ReadLog(2, node, after))
    answer = await receive(stream)
    assert isinstance(answer, machine_link.LogRead)
    return answer.entries


async def test_checkpoint_records_the_containers_session(attach: Attach, store: SlowStore) -> None:
    spec = msgspec.structs.replace(robot_spec("c2"), session="c1")
    stream = await attach(spec)
    await ask(stream, machine_link.SaveClone(1, {"session": b"c9", "origin": b"elsewhere"}))
    assert store.clone("ann", "tb1").nodes == marks(spec, "")
    assert marks(spec, "")["session"] == b"c1"


async def test_planning_container_cannot_save_clones_or_share(attach: Attach, fabric: FakeFabric) -> None:
    stream = await attach(planning_spec())
    stream.write(machine_link.FabricPublish("amcl_pose", b"{}"))
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) == "not-permitted"
    assert fabric.published == []
    assert fabric.subscriptions == []


@pytest.mark.parametrize(
    "spoof",
    [{"user": "bob"}, {"map": "vault"}, {"version": "v2"}, {"robot": "tb2"}, {"robot": None}],
    ids=["user", "map", "version", "robot", "no robot"],
)
async def test_plan_in_another_name_is_refused_and_its_own_is_stored(
    attach: Attach, store: SlowStore, spoof: dict[str, str]
) -> None:
    stream = await attach(robot_spec("c1", "ann", "tb1"))
    mine = {"user": "ann", "map": "house", "version": "v1", "robot": "tb1"}
    assert slug(await ask(stream, machine_link.KeepPlan(1, records.plan("bad", **(mine | spoof))))) == "not-permitted"
    assert slug(await ask(stream, machine_link.KeepPlan(2, records.plan("good", **mine)))) is None
    assert [plan.id for plan in store.plans("house") + store.plans("vault")] == ["good"]


async def test_container_prepares_an_index_of_its_own_map(gateway: ContainerGateway, attach: Attach) -> None:
    prepared = []

    async def prepare(planner: str) -> None:
        if planner != "hub_labels":
            raise NotFound("index", planner, ["hub_labels"])
        prepared.append(planner)

    gateway.expect(planning_spec("c1"), "secret", prepare)
    stream = await dial_gateway(gateway.path)
    stream.write(machine_link.AttachContainer("c1", "secret"))
    assert slug(await ask(stream, machine_link.PrepareIndex(1, "hub_labels"))) is None
    assert slug(await ask(stream, machine_link.PrepareIndex(2, "astar"))) == "not-found"
    assert prepared == ["hub_labels"]
    await stream.close()
    other = await attach(planning_spec("c2"))
    assert slug(await ask(other, machine_link.PrepareIndex(3, "hub_labels"))) == "unavailable"
    await other.close()


async def test_checkpoints_are_stored_in_order(attach: Attach, store: SlowStore) -> None:
    stream = await attach(robot_spec())
    store.go.clear()
    for number in range(1, MAX_REQUESTS + 1):
        stream.write(machine_link.SaveClone(number, {"n": str(number).encode()}))
    store.go.set()
    answers = [await done(stream) for _ in range(MAX_REQUESTS)]
    assert answers == [machine_link.Done(number) for number in range(1, MAX_REQUESTS + 1)]
    assert store.clone("ann", "tb1").nodes["n"] == str(MAX_REQUESTS).encode()


async def test_pending_requests_are_bounded_and_do_not_block_sharing(
    attach: Attach, store: SlowStore, fabric: FakeFabric
) -> None:
    stream = await attach(robot_spec())
    store.go.clear()
    for number in range(MAX_REQUESTS + 1):
        stream.write(machine_link.SaveClone(number, {}))
    stream.write(machine_link.FabricPublish("amcl_pose", b"{}"))
    refused = await done(stream)
    assert (refused.request, slug(refused)) == (MAX_REQUESTS, "quota-exceeded")
    await until(lambda: fabric.published)
    store.go.set()
    assert [await done(stream) for _ in range(MAX_REQUESTS)] == [machine_link.Done(n) for n in range(MAX_REQUESTS)]
    assert slug(await ask(stream, machine_link.SaveClone(99, {}))) is None


@pytest.mark.parametrize(
    ("error", "expected"), [(Unavailable("the disk is full"), "unavailable"), (OSError(5), "error")]
)
async def test_store_error_is_reported_and_the_connection_stays_open(
    attach: Attach, store: SlowStore, error: Exception, expected: str
) -> None:
    stream = await attach(robot_spec())
    store.error = error
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) == expected
    store.error = None
    assert slug(await ask(stream, machine_link.SaveClone(2, {}))) is None


async def test_store_may_answer_after_the_container_disconnected(
    attach: Attach, store: SlowStore, caplog: pytest.LogCaptureFixture
) -> None:
    stream = await attach(robot_spec())
    store.go.clear()
    stream.write(machine_link.SaveClone(1, {"n": b"last"}))
    await stream.close()
    store.go.set()
    await until(lambda: "n" in _nodes(store))
    assert caplog.records == []


def _nodes(store: SlowStore) -> dict[str, bytes]:
    try:
        return store.clone("ann", "tb1").nodes
    except NotFound:
        return {}


@pytest.mark.parametrize(("container", "secret"), [("p1", "wrong"), ("p2", "secret")])
async def test_a_stranger_cannot_be_answered_for(
    gateway: ContainerGateway, attach: Attach, container: str, secret: str
) -> None:
    await attach(planning_spec("p1"))
    stranger = await dial_gateway(gateway.path)
    stranger.write(machine_link.Compiling(container, secret))
    assert await receive(stranger) is None
    assert gateway.kernels.compiling() == ()

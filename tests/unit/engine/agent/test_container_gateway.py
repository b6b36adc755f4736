"""Container gateway of a machine, with valid and misbehaving containers."""

import asyncio
import stat
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import msgspec
import pytest

from engine.agent.container_gateway import MAX_REQUESTS, ContainerGateway
from engine.agent.fleet_topics import MAX_SHARED, MAX_WAITING
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.checkpoints import marks
from engine.specs.containers import ContainerSpec, MapVersion
from ppaas.errors import NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.engine_links import dial_gateway, receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import planning_spec, robot_spec
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

    def save_clone(self, checkpoint: CloneCheckpoint) -> None:
        assert self.go.wait(10)
        if self.error is not None:
            raise self.error
        super().save_clone(checkpoint)


@pytest.fixture
def store() -> SlowStore:
    return SlowStore()


@pytest.fixture
def fabric() -> FakeFabric:
    return FakeFabric()


@pytest.fixture
async def gate(tmp_path: Path, store: SlowStore, fabric: FakeFabric) -> AsyncIterator[ContainerGateway]:
    opened = ContainerGateway(tmp_path / "gate.sock", store, fabric, attach_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


Attach = Callable[[ContainerSpec], Awaitable[Stream]]


@pytest.fixture
def attach(gate: ContainerGateway, fabric: FakeFabric) -> Attach:
    async def attached(spec: ContainerSpec) -> Stream:
        gate.expect(spec, "secret")
        stream = await dial_gateway(gate.path)
        stream.write(machine_link.Attach(spec.id, "secret"))
        await until(lambda: gate.awaited == 0)
        return stream

    return attached


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


# -- notifications -----------------------------------------------------------------------------------------------------


async def test_a_container_learns_its_new_size_and_who_is_gone_is_left_alone(
    gate: ContainerGateway, attach: Attach
) -> None:
    stream = await attach(robot_spec("c1"))
    gate.resized("c2", 4)
    gate.resized("c1", 2)
    assert await receive(stream) == machine_link.Resized(2)
    await stream.close()
    await until(lambda: gate._guests == {})
    gate.resized("c1", 1)


async def test_all_but_those_that_are_to_end_are_told_that_an_endpoint_awaits_them(
    gate: ContainerGateway, attach: Attach
) -> None:
    stays, ends = await attach(robot_spec("c1")), await attach(robot_spec("c2", robot="tb2"))
    gate.shut_out("c2")
    gate.endpoint_came()
    gate.resized("c2", 1)
    assert await receive(stays) == machine_link.EndpointCame()
    assert await receive(ends) == machine_link.Resized(1)


# -- attaching ---------------------------------------------------------------------------------------------------------


async def test_only_this_user_may_dial(gate: ContainerGateway) -> None:
    assert stat.S_IMODE(gate.path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "first",
    [
        machine_link.Attach("c1", "wrong"),
        machine_link.Attach("c1", "schlüssel"),
        machine_link.Attach("c2", "secret"),
        machine_link.SaveClone(1, {}),
    ],
    ids=["wrong secret", "odd secret", "unknown container", "nameless"],
)
async def test_a_stranger_is_hung_up_on_and_the_awaited_container_still_comes(
    gate: ContainerGateway, first: msgspec.Struct, attach: Attach
) -> None:
    gate.expect(robot_spec("c1"), "secret")
    stranger = await dial_gateway(gate.path)
    stranger.write(first)
    assert await receive(stranger) is None
    stream = await attach(robot_spec("c1"))
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) is None


async def test_a_container_attaches_once(gate: ContainerGateway, attach: Attach) -> None:
    first = await attach(robot_spec("c1"))
    second = await dial_gateway(gate.path)
    second.write(machine_link.Attach("c1", "secret"))
    assert await receive(second) is None
    assert slug(await ask(first, machine_link.SaveClone(1, {}))) is None


async def test_a_container_that_wants_to_be_another_is_cut_off(gate: ContainerGateway, attach: Attach) -> None:
    stream, other = await attach(robot_spec("c1")), robot_spec("c2", "bob")
    gate.expect(other, "secret")
    stream.write(machine_link.Attach("c2", "secret"))
    assert await receive(stream) is None
    assert gate.awaited == 1


async def test_who_is_forgotten_is_not_let_in(gate: ContainerGateway) -> None:
    gate.expect(robot_spec("c1"), "secret")
    gate.forget("c1")
    stream = await dial_gateway(gate.path)
    stream.write(machine_link.Attach("c1", "secret"))
    assert await receive(stream) is None


async def test_silence_is_cut_off(tmp_path: Path, store: SlowStore, fabric: FakeFabric) -> None:
    gate = ContainerGateway(tmp_path / "gate.sock", store, fabric, attach_timeout=0.05)
    await gate.start()
    stream = await dial_gateway(gate.path)
    assert await receive(stream) is None
    await gate.close()


# -- the stores --------------------------------------------------------------------------------------------------------


async def test_a_checkpoint_is_kept_under_the_robot_of_the_container_and_no_other(
    attach: Attach, store: SlowStore
) -> None:
    stream = await attach(robot_spec("c1", "ann", "tb1"))
    await attach(robot_spec("c2", "bob", "tb1"))
    nodes = {"amcl": b"{}", "user": b"bob", "../bob/tb1": b"x"}
    assert slug(await ask(stream, machine_link.SaveClone(1, nodes))) is None
    assert store.clone("ann", "tb1").nodes.items() >= nodes.items()
    for user, robot in (("bob", "tb1"), ("ann", "tb2")):
        with pytest.raises(NotFound):
            store.clone(user, robot)


async def test_a_checkpoint_is_marked_with_the_session_of_its_container(attach: Attach, store: SlowStore) -> None:
    spec = msgspec.structs.replace(robot_spec("c2"), session="c1")
    stream = await attach(spec)
    await ask(stream, machine_link.SaveClone(1, {"session": b"c9", "origin": b"elsewhere"}))
    assert store.clone("ann", "tb1").nodes == marks(spec, "")
    assert marks(spec, "")["session"] == b"c1"


async def test_a_container_that_only_plans_has_no_clone_and_shares_nothing(attach: Attach, fabric: FakeFabric) -> None:
    stream = await attach(planning_spec())
    stream.write(machine_link.Share("amcl_pose", b"{}"))
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) == "not-permitted"
    assert fabric.published == []
    assert fabric.subscriptions == []


@pytest.mark.parametrize(
    "spoof",
    [{"user": "bob"}, {"map": "vault"}, {"version": "v2"}, {"robot": "tb2"}, {"robot": None}],
    ids=["user", "map", "version", "robot", "no robot"],
)
async def test_a_plan_in_anothers_name_is_refused_and_its_own_is_kept(
    attach: Attach, store: SlowStore, spoof: dict[str, str]
) -> None:
    stream = await attach(robot_spec("c1", "ann", "tb1"))
    mine = {"user": "ann", "map": "house", "version": "v1", "robot": "tb1"}
    assert slug(await ask(stream, machine_link.KeepPlan(1, records.plan("bad", **(mine | spoof))))) == "not-permitted"
    assert slug(await ask(stream, machine_link.KeepPlan(2, records.plan("good", **mine)))) is None
    assert [plan.id for plan in store.plans("house") + store.plans("vault")] == ["good"]


async def test_a_container_has_what_planners_prepare_of_its_own_map_put_beside_its_layers(
    gate: ContainerGateway, attach: Attach
) -> None:
    prepared = []

    async def prepare(planner: str) -> None:
        if planner != "hub_labels":
            raise NotFound("index", planner, ["hub_labels"])
        prepared.append(planner)

    gate.expect(planning_spec("c1"), "secret", prepare)
    stream = await dial_gateway(gate.path)
    stream.write(machine_link.Attach("c1", "secret"))
    assert slug(await ask(stream, machine_link.PrepareIndex(1, "hub_labels"))) is None
    assert slug(await ask(stream, machine_link.PrepareIndex(2, "astar"))) == "not-found"
    assert prepared == ["hub_labels"]
    await stream.close()
    other = await attach(planning_spec("c2"))
    assert slug(await ask(other, machine_link.PrepareIndex(3, "hub_labels"))) == "unavailable"
    await other.close()


async def test_checkpoints_are_kept_in_the_order_in_which_they_were_made(attach: Attach, store: SlowStore) -> None:
    stream = await attach(robot_spec())
    store.go.clear()
    for number in range(1, MAX_REQUESTS + 1):
        stream.write(machine_link.SaveClone(number, {"n": str(number).encode()}))
    store.go.set()
    answers = [await done(stream) for _ in range(MAX_REQUESTS)]
    assert answers == [machine_link.Done(number) for number in range(1, MAX_REQUESTS + 1)]
    assert store.clone("ann", "tb1").nodes["n"] == str(MAX_REQUESTS).encode()


async def test_requests_under_way_are_bounded_and_a_slow_store_holds_up_nobody_else(
    attach: Attach, store: SlowStore, fabric: FakeFabric
) -> None:
    stream = await attach(robot_spec())
    store.go.clear()
    for number in range(MAX_REQUESTS + 1):
        stream.write(machine_link.SaveClone(number, {}))
    stream.write(machine_link.Share("amcl_pose", b"{}"))
    refused = await done(stream)
    assert (refused.request, slug(refused)) == (MAX_REQUESTS, "quota-exceeded")
    await until(lambda: fabric.published)
    store.go.set()
    assert [await done(stream) for _ in range(MAX_REQUESTS)] == [machine_link.Done(n) for n in range(MAX_REQUESTS)]
    assert slug(await ask(stream, machine_link.SaveClone(99, {}))) is None


@pytest.mark.parametrize(("error", "told"), [(Unavailable("the disk is full"), "unavailable"), (OSError(5), "error")])
async def test_what_a_store_cannot_do_is_told_and_the_container_is_served_on(
    attach: Attach, store: SlowStore, error: Exception, told: str
) -> None:
    stream = await attach(robot_spec())
    store.error = error
    assert slug(await ask(stream, machine_link.SaveClone(1, {}))) == told
    store.error = None
    assert slug(await ask(stream, machine_link.SaveClone(2, {}))) is None


async def test_a_store_that_answers_after_the_container_has_gone_harms_nobody(
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


# -- the fabric --------------------------------------------------------------------------------------------------------


async def test_robots_of_a_map_hear_each_other_whoever_owns_them_and_not_themselves(attach: Attach) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    ann.write(machine_link.Share("amcl_pose", b"ann"))
    assert await receive(bob) == machine_link.Shared("ann", "tb1", "amcl_pose", b"ann")
    bob.write(machine_link.Share("amcl_pose", b"bob"))
    assert await receive(ann) == machine_link.Shared("bob", "tb1", "amcl_pose", b"bob")


async def test_what_is_private_or_of_another_map_is_not_heard(attach: Attach, fabric: FakeFabric) -> None:
    ann = await attach(robot_spec("c1", "ann"))
    vault = await attach(robot_spec("c2", "bob", version=MapVersion("vault", "v1")))
    vault.write(machine_link.Share("amcl_pose", b"in the vault"))
    await until(lambda: fabric.published)
    for key in ("ppaas/bob/default/tb1/amcl_pose", "ppaas/map/house/bob/tb1/scan", "ppaas/map/house%2Fx/b/r/amcl_pose"):
        fabric.publish(key, b"secret")
    fabric.publish("ppaas/map/house/bob/tb1/amcl_pose", b"shown")
    assert await receive(ann) == machine_link.Shared("bob", "tb1", "amcl_pose", b"shown")


HOSTILE = [
    "*",
    "**",
    "amcl_pose/**",
    "$*",
    "../../bob/tb1/amcl_pose",
    "a/../../../bob/tb1/amcl_pose",
    "..",
    "",
    "/",
    "//amcl_pose",
    "amcl_pose/",
    "a b",
    "amcl_pose?x=1",
    "amcl_pose#",
    "\0",
    "a" * 1000,
    "%2e%2e/bob",
]


@pytest.mark.parametrize("topic", HOSTILE)
async def test_a_hostile_topic_is_refused_and_all_containers_are_served_on(
    attach: Attach, fabric: FakeFabric, topic: str, caplog: pytest.LogCaptureFixture
) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    for _ in range(3):
        ann.write(machine_link.Share(topic, b"evil"))
    ann.write(machine_link.Share("amcl_pose", b"good"))
    assert await receive(bob) == machine_link.Shared("ann", "tb1", "amcl_pose", b"good")
    assert fabric.published == [("ppaas/map/house/ann/tb1/amcl_pose", b"good")]
    assert len([record for record in caplog.records if record.levelname == "WARNING"]) == 1


async def test_a_giant_message_is_not_shared(attach: Attach, fabric: FakeFabric) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    ann.write(machine_link.Share("amcl_pose", bytes(MAX_SHARED + 1)))
    ann.write(machine_link.Share("amcl_pose", bytes(MAX_SHARED)))
    shared = await receive(bob)
    assert isinstance(shared, machine_link.Shared)
    assert len(shared.payload) == MAX_SHARED
    assert len(fabric.published) == 1


async def test_what_waits_for_a_container_that_does_not_read_is_bounded(
    gate: ContainerGateway, attach: Attach, fabric: FakeFabric
) -> None:
    slow = await attach(robot_spec("c1", "ann"))
    payload = bytes(MAX_SHARED)
    for _ in range(200):
        fabric.publish("ppaas/map/house/bob/tb1/amcl_pose", payload)
        await asyncio.sleep(0)
    (stream,) = gate._streams
    assert MAX_WAITING < stream.waiting <= MAX_WAITING + 2 * MAX_SHARED
    await slow.close()


async def test_a_container_that_goes_is_told_nothing_more(
    gate: ContainerGateway, attach: Attach, fabric: FakeFabric
) -> None:
    stream = await attach(robot_spec("c1", "ann"))
    assert len(fabric.subscriptions) == 1
    await stream.close()
    await until(lambda: not gate._streams)
    assert fabric.subscriptions == []


async def test_closing_hangs_up_on_all_even_those_that_have_not_attached(
    gate: ContainerGateway, attach: Attach
) -> None:
    known, silent = await attach(robot_spec("c1")), await dial_gateway(gate.path)
    await until(lambda: len(gate._streams) == 2)
    await gate.close()
    assert await receive(known) is None
    assert await receive(silent) is None
    assert not gate.path.exists()

"""A real Cassandra is killed, frozen and restarted under writes: acknowledged writes are not lost."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import PPaaSError, Unavailable
from ppaas.geometry import poses_along
from storage.cassandra.store import CassandraStore
from storage.records import PlanRecord
from storage.store_and_forward.plan_outbox import PlanOutbox
from storage.store_and_forward.store import StoreAndForward
from tests.servers.cassandra_server import CassandraServer
from tests.support.storage.records import plan, robot, user

pytestmark = pytest.mark.servers

KILLS = 2
WRITING = 1.5
"""Time of writing before each kill [s]."""


@pytest.fixture
def store(cassandra_server: CassandraServer) -> Iterator[CassandraStore]:
    opened = CassandraStore(cassandra_server.url("faults", "?timeout=2"))
    yield opened
    opened.close()
    cassandra_server.empty("faults")


def wandering(name: str) -> PlanRecord:
    """Return a plan of 60 poses that depends on its name."""
    seed = int.from_bytes(name.encode(), "little") % 2**63
    steps = np.random.default_rng(seed).integers(-1, 2, (60, 2))
    return plan(name, poses=poses_along(np.cumsum(steps, axis=0) * 0.05, 0.0).tobytes())


class Writer(threading.Thread):
    """Writes continuously, and records which writes were acknowledged."""

    def __init__(self, write: Callable[[int], None]) -> None:
        super().__init__()
        self.acknowledged: list[int] = []
        self.failed = 0
        self.stopped = threading.Event()
        self._write = write

    def run(self) -> None:
        number = 0
        while not self.stopped.is_set():
            try:
                self._write(number)
                self.acknowledged.append(number)
            except Unavailable:
                self.failed += 1
                time.sleep(0.02)
            number += 1


@contextlib.contextmanager
def writing(*writes: Callable[[int], None]) -> Iterator[list[Writer]]:
    writers = [Writer(write) for write in writes]
    for writer in writers:
        writer.start()
    try:
        yield writers
    finally:
        for writer in writers:
            writer.stopped.set()
            writer.join()


def found_again(store: CassandraStore) -> None:
    """Wait until a store has reconnected to Cassandra, which it tries twice a second."""
    deadline = time.monotonic() + 30.0
    while True:
        try:
            store.users(limit=1)
            return
        except Unavailable:
            assert time.monotonic() < deadline
            time.sleep(0.1)


def test_acknowledged_writes_survive_kill_9_and_the_store_reconnects(
    store: CassandraStore, cassandra_server: CassandraServer
) -> None:
    store.users()
    with writing(
        lambda number: store.add_user(user(f"u{number}")),
        lambda number: store.add_plan(wandering(f"p{number}")),
        lambda number: store.add_plans([wandering(f"q{number}-{n}") for n in range(8)]) and None,
        lambda number: store.put_robot(robot("tb1", parameters={"number": number})) and None,
    ) as (users, plans, many, robots):
        for _ in range(KILLS):
            time.sleep(WRITING)
            cassandra_server.kill()
            cassandra_server.start()
        found_again(store)
        time.sleep(WRITING)
    assert all(writer.acknowledged and writer.failed for writer in (users, plans, many, robots))
    assert {f"u{number}" for number in users.acknowledged} <= {one.id for one in store.users()}
    assert store.robot("ann", "tb1").parameters["number"] >= robots.acknowledged[-1]
    names = [f"p{n}" for n in plans.acknowledged] + [f"q{n}-{k}" for n in many.acknowledged for k in range(8)]
    assert set(names) <= {one.id for one in store.plans("house")}, "acknowledged, and not listed"
    for name in names:
        assert store.plan(name) == wandering(name)


def test_every_listed_plan_is_complete(store: CassandraStore, cassandra_server: CassandraServer) -> None:
    with writing(lambda number: store.add_plans([wandering(f"p{number}-{n}") for n in range(8)]) and None):
        time.sleep(WRITING)
        cassandra_server.kill()
        cassandra_server.start()
    found_again(store)
    for head in store.plans("house"):
        assert store.plan(head.id) == wandering(head.id)


def test_plans_are_queued_while_cassandra_is_down_and_sent_once_in_order(
    store: CassandraStore, cassandra_server: CassandraServer, tmp_path: Path
) -> None:
    arrived: list[str] = []
    add_plans = store.add_plans

    def recorded(records: list[PlanRecord]) -> int:
        count = add_plans(records)
        arrived.extend(record.id for record in records)
        return count

    store.add_plans = recorded  # type: ignore[method-assign, assignment]
    forwarding = StoreAndForward(store, PlanOutbox(tmp_path / "outbox.sqlite"), retry=0.1)  # type: ignore[arg-type]
    store.users()
    cassandra_server.kill()
    names = [f"p{number}" for number in range(150)]
    for name in names:
        forwarding.add_plan(wandering(name))
    assert forwarding.waiting() == 150
    assert forwarding.plan("p7") == wandering("p7")
    with pytest.raises(Unavailable):
        store.users()
    cassandra_server.start()
    deadline = time.monotonic() + 30.0
    while forwarding.waiting():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    found_again(store)
    assert list(dict.fromkeys(arrived)) == names
    assert sorted(one.id for one in store.plans("house")) == sorted(names)
    forwarding.close()


def test_calls_to_a_frozen_cassandra_time_out(store: CassandraStore, cassandra_server: CassandraServer) -> None:
    store.add_plan(wandering("p0"))
    cassandra_server.freeze()
    try:
        began = time.monotonic()
        with pytest.raises(Unavailable, match="timeout: check"):
            store.add_plan(wandering("p1"))
        assert time.monotonic() - began < 10.0
    finally:
        cassandra_server.thaw()
    deadline = time.monotonic() + 30.0
    while True:
        with contextlib.suppress(PPaaSError):
            store.add_plan(wandering("p1"))
            break
        assert time.monotonic() < deadline
    assert store.plan("p1") == wandering("p1")

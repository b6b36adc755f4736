"""Tests of the queue of requests that wait for a container."""

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.machine import Machine
from engine.master.master import Master
from engine.master.orders import Order, Start
from engine.master.places import PlaceRequest
from engine.master.queueing import MAX_QUEUED, MAX_QUEUED_OF_USER, Queue
from engine.master.quotas import Quota, Quotas
from ppaas.errors import InvalidParameter, QuotaExceeded
from storage.records import Limits
from tests.support.engine.specs import HOUSE, robot_config
from tests.support.storage.records import user


def request(name: str, owner: str = "ann", cores: float = 1.0, **labels: str) -> PlaceRequest:
    return PlaceRequest(owner, HOUSE, cores, robot_config(name), labels=labels)


@pytest.fixture
def quotas() -> Quotas:
    return Quotas(Quota(containers=8, cores=8.0))


@pytest.fixture
def master(quotas: Quotas) -> Master:
    made = Master(FirstFit(), quotas)
    made.machine_joined(Machine("m1", 1, 8 << 30, 1000))
    return made


@pytest.fixture
def queue(master: Master, quotas: Quotas) -> Queue:
    """Return a queue in front of a machine without free room."""
    made = Queue(quotas)
    for number in range(4):
        assert made.open(request(f"full{number}", "zoe"), master.open)
    return made


def started(orders: list[Order]) -> list[str]:
    return [order.place for order in orders if isinstance(order, Start)]


def test_they_are_served_in_the_order_in_which_they_came(master: Master, queue: Queue) -> None:
    for name in ("r1", "r2", "r3"):
        assert queue.open(request(name), master.open) == []
    assert [queue.position(f"robot:ann/{name}") for name in ("r1", "r2", "r3", "r4")] == [1, 2, 3, None]
    assert queue.serve(master.open) == []
    master.close("robot:zoe/full0")
    assert started(queue.serve(master.open)) == ["robot:ann/r1"]
    assert queue.position("robot:ann/r2") == 1
    master.machine_joined(Machine("m2", 1, 8 << 30, 1001))
    assert started(queue.serve(master.open)) == ["robot:ann/r2", "robot:ann/r3"]
    assert queue.position("robot:ann/r2") is None


def test_a_large_one_keeps_its_position_and_no_small_one_from_being_served(master: Master, queue: Queue) -> None:
    master.close("robot:zoe/full0")
    master.open(request("half", "zoe", 0.5))
    for name, cores in (("large", 1.0), ("larger", 1.0), ("small", 0.25)):
        queue.open(request(name, cores=cores), master.open)
    assert queue.position("robot:ann/small") is None, "it fits, and need not wait"
    assert started(queue.serve(master.open)) == []
    master.close("robot:zoe/full1")
    assert started(queue.serve(master.open)) == ["robot:ann/large"]


def test_who_waits_for_the_own_quota_holds_up_nobody(master: Master, quotas: Quotas) -> None:
    quotas.learn(user("ann", limits=Limits(containers=1)))
    queue = Queue(quotas)
    queue.open(request("r1"), master.open)
    assert queue.open(request("r2"), master.open) == []
    assert started(queue.open(request("r1", "bob"), master.open)) == ["robot:bob/r1"]
    quotas.learn(user("ann", limits=Limits(containers=2)))
    assert started(queue.serve(master.open)) == ["robot:ann/r2"]


def test_labels_that_are_missing_hold_up_nobody_else(master: Master, queue: Queue) -> None:
    queue.open(request("picky", gpu="yes"), master.open)
    queue.open(request("r1"), master.open)
    master.close("robot:zoe/full0")
    assert started(queue.serve(master.open)) == ["robot:ann/r1"]
    assert queue.position("robot:ann/picky") == 1


def test_what_a_user_may_never_have_is_refused(master: Master, queue: Queue, quotas: Quotas) -> None:
    quotas.learn(user("ann", limits=Limits(cores=0.5)))
    with pytest.raises(QuotaExceeded, match=r"0\.5 cores"):
        queue.open(request("r1"), master.open)
    with pytest.raises(InvalidParameter):
        queue.open(request("r1", cores=-1.0), master.open)
    assert queue.get("robot:ann/r1") is None


def test_who_goes_leaves_the_queue(master: Master, queue: Queue) -> None:
    for name in ("r1", "r2"):
        queue.open(request(name), master.open)
    queue.remove("robot:ann/r1")
    queue.remove("robot:ann/r1")
    assert (queue.position("robot:ann/r2"), queue.get("robot:ann/r2")) == (1, request("r2"))


def test_the_queue_is_bounded_for_each_user_and_for_all(master: Master, queue: Queue) -> None:
    for number in range(MAX_QUEUED):
        queue.open(request("r", f"u{number // MAX_QUEUED_OF_USER}-{number}"), master.open)
    with pytest.raises(QuotaExceeded, match=f"it holds {MAX_QUEUED} of at most {MAX_QUEUED}"):
        queue.open(request("r", "late"), master.open)
    for number in range(MAX_QUEUED - MAX_QUEUED_OF_USER):
        queue.remove(f"robot:u{number // MAX_QUEUED_OF_USER}-{number}/r")
    for number in range(MAX_QUEUED_OF_USER):
        queue.open(request(f"r{number}", "greedy"), master.open)
    with pytest.raises(QuotaExceeded, match=f"{MAX_QUEUED_OF_USER} of at most {MAX_QUEUED_OF_USER} of user 'greedy'"):
        queue.open(request("one more", "greedy"), master.open)

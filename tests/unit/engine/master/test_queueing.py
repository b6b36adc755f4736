"""Tests of the queue of requests that wait for a container."""

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.events import LimitsChanged, PlaceReleased, PlaceRequested, ShutdownBegan
from engine.master.master import Master
from engine.master.orders import Order, Start
from engine.master.places import PlaceRequest
from engine.master.queueing import MAX_QUEUED, MAX_QUEUED_OF_USER
from engine.master.quotas import Quota, Quotas
from ppaas.errors import InvalidParameter, QuotaExceeded
from storage.records import Limits
from tests.support.engine.placing import joined
from tests.support.engine.specs import HOUSE, robot_config


def request(name: str, owner: str = "ann", cores: float = 1.0, **labels: str) -> PlaceRequest:
    return PlaceRequest(owner, HOUSE, cores, robot_config(name), labels=labels)


def queued(name: str, owner: str = "ann", cores: float = 1.0, **labels: str) -> PlaceRequested:
    return PlaceRequested(request(name, owner, cores, **labels), queue=True)


@pytest.fixture
def master() -> Master:
    """Return the master of a machine with room for four containers."""
    made = Master(FirstFit(), Quotas(Quota(containers=8, cores=8.0)))
    made.handle(joined("m1", 1, memory=8 << 30))
    return made


@pytest.fixture
def full(master: Master) -> Master:
    """Return the master of a machine without free room."""
    for number in range(4):
        assert master.handle(queued(f"full{number}", "zoe"))
    return master


def started(orders: list[Order]) -> list[str]:
    return [order.place for order in orders if isinstance(order, Start)]


def test_requests_are_served_in_order_and_know_their_positions(full: Master) -> None:
    for name in ("r1", "r2", "r3"):
        assert full.handle(queued(name)) == []
    assert [full.position(f"robot:ann/{name}") for name in ("r1", "r2", "r3", "r4")] == [1, 2, 3, None]
    assert started(full.handle(PlaceReleased("robot:zoe/full0"))) == ["robot:ann/r1"]
    assert full.position("robot:ann/r2") == 1
    assert started(full.handle(joined("m2", 1, memory=8 << 30))) == ["robot:ann/r2", "robot:ann/r3"]
    assert full.position("robot:ann/r2") is None


def test_a_large_request_keeps_its_position_and_does_not_block_a_small_one(full: Master) -> None:
    full.handle(PlaceReleased("robot:zoe/full0"))
    full.handle(PlaceRequested(request("half", "zoe", 0.5)))
    for name, cores in (("large", 1.0), ("larger", 1.0), ("small", 0.25)):
        full.handle(queued(name, cores=cores))
    assert full.position("robot:ann/small") is None, "it fits, and need not wait"
    assert [full.position(f"robot:ann/{name}") for name in ("large", "larger")] == [1, 2]
    assert started(full.handle(PlaceReleased("robot:zoe/full1"))) == ["robot:ann/large"]


def test_user_waiting_for_the_quota_does_not_block_other_users(master: Master) -> None:
    master.handle(LimitsChanged("ann", Limits(containers=1)))
    master.handle(queued("r1"))
    assert master.handle(queued("r2")) == []
    assert started(master.handle(queued("r1", "bob"))) == ["robot:bob/r1"]
    assert started(master.handle(LimitsChanged("ann", Limits(containers=2)))) == ["robot:ann/r2"]


def test_request_for_missing_labels_does_not_block_others(full: Master) -> None:
    full.handle(queued("demanding", gpu="yes"))
    full.handle(queued("r1"))
    assert started(full.handle(PlaceReleased("robot:zoe/full0"))) == ["robot:ann/r1"]
    assert full.position("robot:ann/demanding") == 1


def test_request_above_the_quota_or_of_invalid_size_is_refused(full: Master) -> None:
    full.handle(LimitsChanged("ann", Limits(cores=0.5)))
    with pytest.raises(QuotaExceeded, match=r"0\.5 cores"):
        full.handle(queued("r1"))
    with pytest.raises(InvalidParameter):
        full.handle(queued("r1", cores=-1.0))
    assert full.request_of("robot:ann/r1") is None


def test_a_released_place_leaves_the_queue(full: Master) -> None:
    for name in ("r1", "r2"):
        full.handle(queued(name))
    for _ in range(2):
        full.handle(PlaceReleased("robot:ann/r1"))
    assert (full.position("robot:ann/r2"), full.request_of("robot:ann/r2")) == (1, request("r2"))


def test_the_queue_is_bounded_for_each_user_and_for_all(full: Master) -> None:
    for number in range(MAX_QUEUED):
        full.handle(queued("r", f"u{number // MAX_QUEUED_OF_USER}-{number}"))
    with pytest.raises(QuotaExceeded, match=f"it holds {MAX_QUEUED} of at most {MAX_QUEUED}"):
        full.handle(queued("r", "late"))
    for number in range(MAX_QUEUED - MAX_QUEUED_OF_USER):
        full.handle(PlaceReleased(f"robot:u{number // MAX_QUEUED_OF_USER}-{number}/r"))
    for number in range(MAX_QUEUED_OF_USER):
        full.handle(queued(f"r{number}", "greedy"))
    with pytest.raises(QuotaExceeded, match=f"{MAX_QUEUED_OF_USER} of at most {MAX_QUEUED_OF_USER} of user 'greedy'"):
        full.handle(queued("one more", "greedy"))


def test_no_queued_place_is_opened_while_the_cloud_shuts_down(full: Master) -> None:
    full.handle(queued("r1"))
    full.handle(ShutdownBegan())
    assert started(full.handle(PlaceReleased("robot:zoe/full0"))) == []

"""Tests of requests that do not fit now: queued, or refused with a reason, and the balancer is asked once a size."""

from collections.abc import Iterator
from typing import Any

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.events import (
    ContainerReady,
    LimitsChanged,
    MachineLeft,
    MapChanged,
    PlaceReleased,
    PlaceRequested,
    SettingsChanged,
    ShutdownBegan,
)
from engine.master.machine import Machine
from engine.master.master import Master
from engine.master.orders import Order, Start
from engine.master.places import PlaceAssignment, PlaceRequest
from engine.master.queueing import MAX_QUEUED, MAX_QUEUED_OF_USER, FullMachines, explain_no_machine
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import InvalidParameter, QuotaExceeded
from storage.records import Limits
from tests.support.engine.placing import joined, machine
from tests.support.engine.specs import HOUSE, robot_config, robot_request


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


ROBOTS = 10


class CountingFirstFit(FirstFit):
    """Counts how often it is asked."""

    asked = 0

    def choose(self, spec: ContainerSpec) -> Machine | None:
        self.asked += 1
        return super().choose(spec)


@pytest.fixture
def balancer() -> CountingFirstFit:
    return CountingFirstFit()


@pytest.fixture
def counted_master(balancer: CountingFirstFit) -> Master:
    made = Master(balancer)
    made.handle(joined("m1", 8, memory=1 << 32))
    return made


def run(counted_master: Master, robot: str, **fields: Any) -> None:
    [start] = counted_master.handle(PlaceRequested(robot_request(robot, **fields)))
    assert isinstance(start, Start)
    counted_master.handle(ContainerReady(start.spec.id, 42))


def test_larger_sizes_with_the_same_labels_are_refused() -> None:
    full, labelled = FullMachines(), {"zone": "a"}
    assert not full.refuse(robot_request(cores=8.0))
    full.note(robot_request(cores=2.0))
    assert full.refuse(PlaceAssignment(robot_request(cores=2.0))) and full.refuse(robot_request(cores=4.0))
    assert not full.refuse(robot_request(cores=1.0)) and not full.refuse(robot_request(cores=4.0, labels=labelled))
    resized = PlaceAssignment(robot_request(cores=2.0), resized=1.0)
    assert not full.refuse(resized), "its next container is smaller"
    full.note(resized)
    assert full.refuse(robot_request(cores=1.0))


def test_a_drained_machine_without_another_asks_once(counted_master: Master, balancer: CountingFirstFit) -> None:
    for number in range(ROBOTS):
        run(counted_master, f"r{number}")
    balancer.asked = 0
    counted_master.handle(SettingsChanged("m1", MachineSettings(draining=True)))
    assert balancer.asked == 1


def test_places_that_wait_ask_once_for_each_set_of_labels(counted_master: Master, balancer: CountingFirstFit) -> None:
    labels = {"zone": "a"}
    counted_master.handle(joined("m2", 8, memory=1 << 32, labels=labels))
    for number in range(ROBOTS):
        run(counted_master, f"r{number}")
        run(counted_master, f"a{number}", labels=labels)
    counted_master.handle(MachineLeft("m2"))
    balancer.asked = 0
    counted_master.handle(PlaceReleased("robot:ann/r0"))
    assert balancer.asked == 1
    assert len(counted_master.handle(joined("m3", 8, memory=1 << 32, labels=labels))) == ROBOTS


def test_only_places_of_a_map_are_examined_when_it_changes(
    monkeypatch: pytest.MonkeyPatch, counted_master: Master
) -> None:
    examined: list[str] = []

    def examine(request: PlaceRequest, event: MapChanged) -> PlaceRequest:
        examined.append(request.key)
        return request

    def requests() -> Iterator[PlaceRequest]:
        zones = {"keepout_filter": MapVersion("zones", "v1")}
        for number in range(ROBOTS):
            yield PlaceRequest("ann", MapVersion("depot", "v1"), 1.0, robot_config(f"d{number}"))
        yield PlaceRequest("ann", MapVersion("zones", "v1"), 1.0, robot_config("z", masks=zones))
        yield PlaceRequest("ann", MapVersion("house", "v1"), 1.0, robot_config("h", masks=zones))

    for request in requests():
        counted_master.handle(PlaceRequested(request))
    monkeypatch.setattr("engine.master.master.with_version", examine)
    counted_master.handle(MapChanged(MapVersion("zones", "v2")))
    assert examined == ["robot:ann/z", "robot:ann/h"]
    counted_master.handle(PlaceReleased("robot:ann/z"))
    counted_master.handle(MapChanged(MapVersion("zones", "v3")))
    assert examined[2:] == ["robot:ann/h"]


def test_full_cloud_is_reported_with_the_requested_size() -> None:
    why = explain_no_machine(robot_request(cores=2.0), {"m1": machine("m1")})
    assert why == "no machine has room for a container of 2.0 cores: try again later"


def test_machines_are_not_examined_for_a_request_without_labels(monkeypatch: pytest.MonkeyPatch) -> None:
    def examine(_: Machine) -> dict[str, str]:
        raise AssertionError

    monkeypatch.setattr(Machine, "all_labels", property(examine))
    assert explain_no_machine(robot_request(), {"m1": machine("m1")}).startswith("no machine has room")


def test_machine_with_the_fewest_missing_labels_is_named() -> None:
    machines = {
        name: machine(name, labels=labels)
        for name, labels in (("m1", {}), ("m2", {"a": "1", "b": "2"}), ("m3", {"a": "1"}))
    }
    why = explain_no_machine(robot_request(labels={"a": "1", "b": "2", "c": "3"}), machines)
    assert why == "no machine has the labels a=1, b=2, c=3; 'm2' is closest, but lacks c=3"


def test_label_with_another_value_counts_as_missing() -> None:
    why = explain_no_machine(robot_request(labels={"a": "1"}), {"m1": machine("m1", labels={"a": "2"})})
    assert why.endswith("lacks a=1")

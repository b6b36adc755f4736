"""Tests of the master as a pure state machine."""

import contextlib
from collections.abc import Sequence

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from engine.master.balancers.first_fit import FirstFit
from engine.master.crashes import CRASH_LIMIT, CRASH_WINDOW, RESTART_DELAYS
from engine.master.draining import MOVES
from engine.master.machine import Machine
from engine.master.master import Master
from engine.master.orders import Close, End, Start
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import MapVersion, RobotConfig
from engine.specs.machine_settings import MachineSettings
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, InvalidMap, InvalidParameter, NotFound, NotPermitted, QuotaExceeded, Unavailable

MAP = MapVersion("office", "v1")


def robot(name: str, user: str = "alice", cores: float = 1.0) -> PlaceRequest:
    config = RobotConfig(name, "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    return PlaceRequest(user, MAP, cores, config)


def machine(name: str, cores: int = 2) -> Machine:
    return Machine(name, cores, 1 << 30, 1000)


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def master(clock: ManualClock) -> Master:
    return Master(FirstFit(), Quotas(Quota(containers=8, cores=8.0)), clock)


def started(orders: Sequence[object]) -> list[Start]:
    return [order for order in orders if isinstance(order, Start)]


def test_a_container_goes_to_the_first_machine_with_room(master: Master) -> None:
    master.machine_joined(machine("m1", 1))
    master.machine_joined(machine("m2", 2))
    places = [started(master.open(robot(f"r{n}")))[0].machine for n in range(6)]
    assert places == ["m1"] * 4 + ["m2"] * 2


def test_opening_an_open_place_orders_nothing(master: Master) -> None:
    master.machine_joined(machine("m1"))
    assert len(master.open(robot("r1"))) == 1
    assert master.open(robot("r1")) == []


def test_robots_of_two_users_may_have_one_name(master: Master) -> None:
    master.machine_joined(machine("m1"))
    assert started(master.open(robot("r1", "alice"))) and started(master.open(robot("r1", "bob")))


@pytest.mark.parametrize("cores", [0.0, -1.0, float("nan"), float("inf")])
def test_a_size_is_positive_and_finite(master: Master, cores: float) -> None:
    master.machine_joined(machine("m1"))
    with pytest.raises(InvalidParameter):
        master.open(robot("r1", cores=cores))


def test_a_size_over_the_largest_machine_is_refused(master: Master) -> None:
    master.machine_joined(machine("m1", 2))
    with pytest.raises(QuotaExceeded, match="2"):
        master.open(robot("r1", cores=3.0))


def test_a_quota_is_named_when_it_is_reached(clock: ManualClock) -> None:
    master = Master(FirstFit(), Quotas(Quota(containers=2, cores=1.5)), clock)
    master.machine_joined(machine("m1"))
    master.open(robot("r1"))
    with pytest.raises(QuotaExceeded, match=r"1\.5 cores"):
        master.open(robot("r2", cores=1.0))
    master.open(robot("r2", cores=0.5))
    with pytest.raises(QuotaExceeded, match="2 containers"):
        master.open(robot("r3", cores=0.1))
    assert started(master.open(robot("r1", "bob")))


def test_no_room_is_told_and_leaves_no_trace(master: Master) -> None:
    master.machine_joined(machine("m1", 1))
    for n in range(4):
        master.open(robot(f"r{n}"))
    with pytest.raises(Unavailable, match="room"):
        master.open(robot("r5"))
    assert len(master.places) == 4


def test_places_wait_for_the_first_machine(master: Master) -> None:
    assert master.open(robot("r1")) == []
    assert [order.place for order in started(master.machine_joined(machine("m1")))] == ["robot:alice/r1"]


def test_a_lost_container_is_replaced_by_one_of_another_id(master: Master) -> None:
    master.machine_joined(machine("m1"))
    first = started(master.open(robot("r1")))[0].spec.id
    assert master.container_ready(first, 77) == "robot:alice/r1"
    second = started(master.container_lost(first, Unavailable("gone")))[0].spec.id
    assert second != first
    assert master.container_lost(first, Unavailable("late news")) == []
    assert master.container_ready(first, 77) is None


def test_the_process_that_its_machine_tells_is_the_one_that_is_shown(master: Master) -> None:
    master.machine_joined(machine("m1"))
    first, second = (started(master.open(robot(name)))[0].spec.id for name in ("r1", "r2"))
    master.container_launched(first, 4711)
    for container in (first, second):
        master.container_ready(container, 7)
    master.container_launched(second, 4712)
    assert {place.pid for place in master.places.values()} == {4711, 4712}


def test_a_crash_loop_closes_the_place_and_says_why(master: Master, clock: ManualClock) -> None:
    master.machine_joined(machine("m1"))
    orders = master.open(robot("r1"))
    for _ in range(CRASH_LIMIT):
        orders = master.container_lost(started(orders)[0].spec.id, Unavailable("boom"))
        clock.advance(1.0)
    orders = master.container_lost(started(orders)[0].spec.id, Unavailable("boom"))
    (close,) = orders
    assert isinstance(close, Close) and "boom" in str(close.reason)
    assert not master.places and not master.machines["m1"].containers


def test_rare_crashes_are_no_loop(master: Master, clock: ManualClock) -> None:
    master.machine_joined(machine("m1"))
    orders = master.open(robot("r1"))
    for _ in range(3 * CRASH_LIMIT):
        orders = master.container_lost(started(orders)[0].spec.id, Unavailable("boom"))
        clock.advance(CRASH_WINDOW)
    assert len(started(orders)) == 1


def test_what_can_never_start_is_not_tried_again(master: Master) -> None:
    master.machine_joined(machine("m1"))
    first = started(master.open(robot("r1")))[0].spec.id
    (close,) = master.container_lost(first, InvalidMap("no map at all"))
    assert isinstance(close, Close) and isinstance(close.reason, InvalidMap)


def test_what_was_changed_meanwhile_is_told_and_not_tried_again(master: Master) -> None:
    master.machine_joined(machine("m1"))
    (start,) = started(master.open(robot("r1")))
    (close,) = master.container_lost(start.spec.id, Conflict("the map has a newer version"))
    assert isinstance(close, Close) and isinstance(close.reason, Conflict)
    assert master.places == {}


def test_a_container_that_crashes_again_is_replaced_later_and_later(master: Master, clock: ManualClock) -> None:
    master.machine_joined(machine("m1"))
    (start,) = started(master.open(robot("r1")))
    assert start.delay == 0.0
    delays = []
    for _ in range(CRASH_LIMIT):
        (start,) = started(master.container_lost(start.spec.id, Unavailable("it crashed")))
        delays.append(start.delay)
    assert tuple(delays) == RESTART_DELAYS
    clock.advance(2 * CRASH_WINDOW)
    (start,) = started(master.container_lost(start.spec.id, Unavailable("it crashed")))
    assert start.delay == 0.0


def test_all_containers_of_a_place_are_of_one_session_and_those_of_the_next_place_are_not(master: Master) -> None:
    master.machine_joined(machine("m1"))
    (first,) = started(master.open(robot("r1")))
    (second,) = started(master.container_lost(first.spec.id, Unavailable("it crashed")))
    third = started([*master.machine_left("m1"), *master.machine_joined(machine("m1"))])[0]
    assert {start.spec.session for start in (first, second, third)} == {first.spec.id}
    master.close(robot("r1").key)
    (anew,) = started(master.open(robot("r1")))
    assert anew.spec.session == anew.spec.id


def test_a_place_that_found_no_room_is_filled_when_another_gives_its_room_up(master: Master) -> None:
    master.machine_joined(machine("m1", 1))
    master.machine_joined(machine("m2", 1))
    for number in range(8):
        master.open(robot(f"r{number}"))
    assert master.machine_left("m2") == []
    waiting = [key for key, place in master.places.items() if place.state == "waiting"]
    assert len(waiting) == 4
    end, start = master.close(robot("r0").key)
    assert isinstance(end, End)
    assert isinstance(start, Start) and start.place == waiting[0]
    close, start = master.container_lost(start.spec.id, InvalidMap("not square"))
    assert isinstance(close, Close)
    assert isinstance(start, Start) and start.place == waiting[1]


def test_a_vanished_machine_has_its_places_filled_elsewhere(master: Master) -> None:
    master.machine_joined(machine("m1"))
    master.machine_joined(machine("m2"))
    master.open(robot("r1"))
    master.open(robot("r2"))
    again = started(master.machine_left("m1"))
    assert {order.place for order in again} == {"robot:alice/r1", "robot:alice/r2"}
    assert {order.machine for order in again} == {"m2"}


def test_a_machine_that_comes_again_has_nothing_of_what_it_had(master: Master) -> None:
    master.machine_joined(machine("m1"))
    old = started(master.open(robot("r1")))[0].spec.id
    again = started(master.machine_joined(machine("m1")))
    assert len(again) == 1 and again[0].spec.id != old
    assert list(master.machines["m1"].containers) == [again[0].spec.id]


def test_closing_a_place_ends_its_container(master: Master) -> None:
    master.machine_joined(machine("m1"))
    container = started(master.open(robot("r1")))[0].spec.id
    assert master.close("robot:alice/r1") == [End("m1", container)]
    assert master.close("robot:alice/r1") == []


class MasterMachine(RuleBasedStateMachine):
    """After any sequence of events, the master's counts are correct."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = ManualClock()
        self.master = Master(FirstFit(), Quotas(Quota(6, 4.0)), self.clock)

    @rule(
        name=st.sampled_from("abcdefgh"), user=st.sampled_from(["u", "v"]), cores=st.sampled_from([0.25, 1.0, 2.0, 9.0])
    )
    def open(self, name: str, user: str, cores: float) -> None:
        with contextlib.suppress(QuotaExceeded, Unavailable):
            self.master.open(robot(name, user, cores))

    @rule(name=st.sampled_from(["m1", "m2"]), cores=st.integers(1, 3))
    def join(self, name: str, cores: int) -> None:
        with contextlib.suppress(NotPermitted):
            self.master.machine_joined(machine(name, cores))

    @rule(name=st.sampled_from(["m1", "m2"]), draining=st.booleans())
    def drain(self, name: str, draining: bool) -> None:
        with contextlib.suppress(NotFound):
            self.master.configure(name, MachineSettings(draining=draining))

    @rule(name=st.sampled_from(["m1", "m2"]), force=st.booleans())
    def remove(self, name: str, force: bool) -> None:
        with contextlib.suppress(NotFound, Conflict):
            self.master.remove(name, force=force)
            self.master.admit(name)

    @rule(number=st.integers(1, 60))
    def ready(self, number: int) -> None:
        self.master.container_ready(f"c{number}", 1)
        self.master.move_on()

    @rule(name=st.sampled_from(["m1", "m2"]))
    def vanish(self, name: str) -> None:
        self.master.machine_left(name)

    @precondition(lambda self: self.master.places)
    @rule(data=st.data())
    def close(self, data: st.DataObject) -> None:
        self.master.close(data.draw(st.sampled_from(sorted(self.master.places))))

    @rule(number=st.integers(1, 60))
    def crash(self, number: int) -> None:
        self.master.container_lost(f"c{number}", Unavailable("boom"))

    @invariant()
    def every_container_fills_one_place_and_every_place_at_most_one_container(self) -> None:
        placed = {m.id: set(m.containers) for m in self.master.machines.values()}
        filled: dict[str, set[str]] = {name: set() for name in placed}
        for place in self.master.places.values():
            assert (place.spec is None) == (place.machine is None) == (place.state == "waiting")
            assert place.successor is None or place.leaving
            for machine_id, spec in filter(None, [(place.machine, place.spec), place.successor]):
                if spec is not None and machine_id is not None:
                    filled[machine_id].add(spec.id)
        assert placed == filled

    @invariant()
    def no_more_move_at_a_time_than_may(self) -> None:
        assert sum(place.leaving for place in self.master.places.values()) <= MOVES
        assert self.master.state.moving <= self.master.places.keys()

    @invariant()
    def no_machine_holds_more_than_it_has(self) -> None:
        assert all(m.free >= -1e-9 for m in self.master.machines.values())


MasterMachine.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestMasterStateMachine = MasterMachine.TestCase

"""Tests of the balancers: the machine that a container is placed on."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from engine.master.balancer import Balancer
from engine.master.balancers.first_fit import FirstFit
from engine.master.balancers.ppaas import FEW, LATE, SameMap, Weights, utilization
from engine.master.balancers.registry import BALANCERS
from engine.master.balancers.room_tree import RoomTree
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import NotFound
from tests.support.engine.placing import machine, spec


class Placing:
    """Uses a balancer as the master does."""

    def __init__(self, balancer: Balancer, *machines: Machine) -> None:
        self.balancer = balancer
        self.machines = {each.id: each for each in machines}
        for each in machines:
            balancer.joined(each)

    def place(self, wanted: ContainerSpec) -> str | None:
        """Place a container; return the name of its machine, if any."""
        chosen = self.balancer.choose(wanted)
        if chosen is None:
            return None
        assert chosen.has_room(wanted)
        chosen.place(wanted)
        self.balancer.placed(chosen, wanted)
        return chosen.id

    def remove(self, machine_id: str, container: str) -> None:
        """End a container."""
        carried = self.machines[machine_id]
        removed = carried.remove(container)
        assert removed is not None
        self.balancer.removed(carried, removed)

    def leave(self, machine_id: str) -> None:
        """Remove a machine with all its containers."""
        self.balancer.left(self.machines.pop(machine_id))

    def measure(self, machine_id: str, **figures: Any) -> None:
        """Report measured values of a machine."""
        for name, value in figures.items():
            setattr(self.machines[machine_id], name, value)
        self.balancer.measured(self.machines[machine_id])


@pytest.fixture
def same_map() -> Placing:
    return Placing(SameMap(), *(machine(f"m{number}", 1) for number in range(3)))


def test_first_fit_fills_machines_one_after_the_other() -> None:
    placing = Placing(FirstFit(), machine("m1", 1), machine("m2", 1))
    assert [placing.place(spec(f"c{number}", 0.5)) for number in range(17)] == ["m1"] * 8 + ["m2"] * 8 + [None]
    placing.remove("m1", "c3")
    assert placing.place(spec("again", 0.5)) == "m1"


@pytest.mark.parametrize("name", BALANCERS.names())
def test_drained_full_or_small_machines_get_no_container(name: str) -> None:
    placing = Placing(
        BALANCERS.create(name, {}),
        machine("drained"),
        machine("full", settings=MachineSettings(max_containers=1)),
        machine("small", 1),
    )
    placing.measure("drained", settings=MachineSettings(draining=True))
    assert placing.place(spec("one", 2.0)) == "full"
    assert placing.place(spec("two", 2.0)) is None
    assert placing.place(spec("three", 1.0)) == "small"


def test_robots_of_a_map_share_a_machine_and_maps_are_spread(same_map: Placing) -> None:
    offices = {same_map.place(spec(f"a{number}", 0.5, "office")) for number in range(4)}
    wards = {same_map.place(spec(f"b{number}", 0.5, "ward")) for number in range(4)}
    assert len(offices) == len(wards) == 1
    assert offices != wards


def test_map_continues_on_the_least_used_machine_when_full(same_map: Placing) -> None:
    same_map.measure("m1", cpu=0.9)
    places = [same_map.place(spec(f"c{number}", 1.0)) for number in range(6)]
    assert places == ["m0"] * 4 + ["m2"] * 2
    same_map.remove("m0", "c1")
    assert same_map.place(spec("again", 1.0)) == "m0", "most containers of its map are there"


def test_container_group_shares_a_machine_for_any_maps(same_map: Placing) -> None:
    first = same_map.place(spec("a", 0.25, "office", container_group="fleet"))
    assert same_map.place(spec("b", 0.25, "ward", container_group="fleet")) == first
    assert same_map.place(spec("c", 0.25, "office")) != first


def test_machine_that_left_counts_for_no_map(same_map: Placing) -> None:
    assert same_map.place(spec("a")) == "m0"
    same_map.leave("m0")
    assert same_map.place(spec("b")) == "m1"
    same_map.remove("m1", "b")
    same_map.measure("m1", memory_used=1 << 29)
    assert same_map.place(spec("c")) == "m2"


def test_round_trip_of_a_robot_and_machine_counts_for_that_robot(same_map: Placing) -> None:
    balancer = same_map.balancer
    assert isinstance(balancer, SameMap)
    for number in range(3):
        same_map.measure(f"m{number}", round_trip=0.05)
    balancer.timed("ann/near", "m2", 0.001)
    balancer.timed("ann/far", "m0", 0.09)
    assert same_map.place(spec("a", 1.0, "one", robot="near")) == "m2"
    assert same_map.place(spec("b", 1.0, "two", robot="far")) == "m1"
    balancer.timed("ann/far", "m0", 0.001)
    assert same_map.place(spec("c", 1.0, "three", robot="far")) == "m0"


def test_oldest_round_trips_of_robots_are_dropped(same_map: Placing, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.master.balancers.ppaas.MOST_TIMED", 2)
    for number in range(3):
        same_map.measure(f"m{number}", round_trip=0.05)
        same_map.balancer.timed(f"ann/r{number}", "m2", 0.001)
    assert same_map.place(spec("a", 1.0, "one", robot="r0")) == "m0"
    assert same_map.place(spec("b", 1.0, "two", robot="r1")) == "m2"


def test_score_uses_the_given_weights() -> None:
    busy = machine("m", 2, cpu=1.0, memory_used=1 << 28, network=100.0, network_used=75.0)
    assert utilization(busy, LATE / 10, Weights(1, 0, 0, 0)) == pytest.approx(0.1)
    assert utilization(busy, 0.0, Weights(0, 1, 0, 0)) == pytest.approx(0.75)
    assert utilization(busy, 0.0, Weights(0, 0, 1, 0)) == pytest.approx(0.5)
    assert utilization(busy, 0.0, Weights(0, 0, 0, 1)) == pytest.approx(0.25)
    assert utilization(busy, LATE / 10, Weights()) == pytest.approx((0.1 + 0.75 + 0.5 + 0.25) / 4)
    assert utilization(busy, 100.0, Weights(0, 0, 0, 0)) == 0.0
    busy.given = busy.capacity
    assert utilization(busy, 0.0, Weights(0, 0, 1, 0)) == 1.0, "containers placed just now count too"


def test_unknown_balancer_error_lists_the_installed_ones() -> None:
    with pytest.raises(NotFound, match="first_fit, ppaas"):
        BALANCERS.load("best_fit")


class SameMapTwin(SameMap):
    """Twin of `SameMap` that examines all machines of a group, in the order in which they got its first container."""

    def __init__(self) -> None:
        super().__init__()
        self.counts: dict[str, dict[str, int]] = {}

    def choose(self, spec: ContainerSpec) -> Machine | None:
        best, most = None, 0
        for name, members in self.counts.get(spec.group, {}).items():
            if members > most and self.machines[name].has_room(spec):
                best, most = self.machines[name], members
        return best or self._least_used(spec)

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        super().placed(machine, spec)
        members = self.counts.setdefault(spec.group, {})
        members[machine.id] = members.get(machine.id, 0) + 1

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        super().removed(machine, spec)
        self.counts[spec.group][machine.id] -= 1
        if not self.counts[spec.group][machine.id]:
            del self.counts[spec.group][machine.id]

    def left(self, machine: Machine) -> None:
        super().left(machine)
        for members in self.counts.values():
            members.pop(machine.id, None)


def change(placing: Placing, kind: str, number: int, draw: Random) -> str | None:
    """Let one thing happen to the machines, drawn at random; return where a container was placed."""
    each = placing.machines.get(f"m{draw.randrange(MACHINES)}")
    group, cores, most = (
        draw.choice(["one", "one", "two"]),
        draw.choice([0.25, 0.5, 1.0, 2.0]),
        draw.choice([0, 3, 100]),
    )
    if kind == "place":
        return placing.place(spec(f"c{number}", cores, group))
    if each is None:
        return None
    if kind == "remove" and each.containers:
        placing.remove(each.id, draw.choice(list(each.containers)))
    elif kind == "configure":
        placing.measure(each.id, settings=MachineSettings(max_containers=most))
    elif kind == "replace":
        placing.leave(each.id)
        placing.machines[each.id] = machine(each.id, 2)
        placing.balancer.joined(placing.machines[each.id])
    return None


MACHINES, CHANGES = 3 * FEW, 3_000


@pytest.mark.parametrize("seed", range(4))
def test_a_large_group_is_placed_as_by_a_scan_of_its_machines(seed: int) -> None:
    kinds = Random(seed).choices(["place", "remove", "configure", "replace"], [60, 38, 1, 1], k=CHANGES)
    places = []
    for balancer in (SameMap(), SameMapTwin()):
        placing, draw = Placing(balancer, *(machine(f"m{n}", 1 + n % 2) for n in range(MACHINES))), Random(seed)
        places.append([change(placing, kind, number, draw) for number, kind in enumerate(kinds)])
    assert places[0] == places[1]
    assert len(set(places[0])) > 2 * FEW, "it has more machines than are examined one by one"


def test_a_group_on_many_full_machines_is_not_scanned(monkeypatch: pytest.MonkeyPatch) -> None:
    placing, examined = Placing(SameMap(), *(machine(f"m{number}", 1) for number in range(200))), 0
    for number in range(4 * 200 - 1):
        assert placing.place(spec(f"c{number}", 1.0)) is not None
    has_room = Machine.has_room

    def count(self: Machine, wanted: ContainerSpec) -> bool:
        nonlocal examined
        examined += 1
        return has_room(self, wanted)

    monkeypatch.setattr(Machine, "has_room", count)
    assert placing.balancer.choose(spec("last", 1.0)) is placing.machines["m199"]
    assert examined == 1


class PlacingInAnyOrder(RuleBasedStateMachine):
    """After any sequence of events, the balancers agree with the actual placements."""

    def __init__(self) -> None:
        super().__init__()
        self.placings = [Placing(FirstFit()), Placing(SameMap())]
        self.count = 0

    def each(self) -> Iterator[Placing]:
        return iter(self.placings)

    @rule(name=st.sampled_from("abcdef"), cores=st.integers(1, 3))
    def join(self, name: str, cores: int) -> None:
        for placing in self.each():
            if name not in placing.machines:
                placing.machines[name] = machine(name, cores)
                placing.balancer.joined(placing.machines[name])

    @rule(map_id=st.sampled_from(["one", "two", "three"]), cores=st.sampled_from([0.25, 1.0, 2.0]))
    def place(self, map_id: str, cores: float) -> None:
        self.count += 1
        for placing in self.each():
            fits = any(each.has_room(spec("x", cores)) for each in placing.machines.values())
            assert (placing.place(spec(f"c{self.count}", cores, map_id)) is not None) == fits

    @precondition(lambda self: self.count)
    @rule(data=st.data())
    def remove(self, data: st.DataObject) -> None:
        container = f"c{data.draw(st.integers(1, self.count))}"
        for placing in self.each():
            for each in [each for each in placing.machines.values() if container in each.containers]:
                placing.remove(each.id, container)

    @rule(name=st.sampled_from("abcdef"))
    def leave(self, name: str) -> None:
        for placing in self.each():
            if name in placing.machines:
                placing.leave(name)

    @invariant()
    def map_is_not_spread_while_its_machine_has_capacity(self) -> None:
        placing = self.placings[1]
        for map_id in ("one", "two", "three"):
            members = {
                each.id: sum(one.map.id == map_id for one in each.containers.values())
                for each in placing.machines.values()
            }
            hosts = [each for each in placing.machines.values() if members[each.id] and each.has_room(spec("x", 0.25))]
            if hosts:
                chosen = placing.balancer.choose(spec("x", 0.25, map_id))
                assert chosen is not None
                assert members[chosen.id] == max(members[each.id] for each in hosts)


PlacingInAnyOrder.TestCase.settings = settings(stateful_step_count=40)
TestPlacingInAnyOrder = PlacingInAnyOrder.TestCase


@dataclass
class Twin:
    """Twin of `RoomTree` that examines every machine."""

    known: dict[str, tuple[Machine, float]] = field(default_factory=dict)

    def first(self, size: float) -> Machine | None:
        return next((each for each, _ in self.known.values() if each.has_room(spec("c", size))), None)

    def least(self, size: float, without: set[str]) -> float:
        fits = [
            score for each, score in self.known.values() if each.has_room(spec("c", size)) and each.id not in without
        ]
        return min(fits, default=float("inf"))


names = st.integers(0, 40).map(lambda number: f"m{number}")
steps = st.lists(
    st.tuples(st.just("put"), names, st.floats(0.0, 1.0), st.sampled_from([0.0, 0.5, 1.0, 2.0, 4.0, 8.0]))
    | st.tuples(st.just("remove"), names, st.just(0.0), st.just(0.0)),
    max_size=120,
)


@given(steps, st.sampled_from([0.25, 1.0, 2.0, 3.0]), st.sets(names, max_size=3))
def test_tree_finds_the_same_machines_as_a_full_scan(
    done: list[tuple[str, str, float, float]], size: float, without: set[str]
) -> None:
    tree, twin = RoomTree(), Twin()
    for what, name, score, given_away in done:
        if what == "remove":
            tree.remove(name)
            twin.known.pop(name, None)
            continue
        known = twin.known[name][0] if name in twin.known else machine(name, 2)
        known.given = given_away
        tree.put(known, score)
        twin.known[name] = known, score
    assert len(tree) == len(twin.known)
    assert tree.first(spec("c", size)) is twin.first(size)
    least, found = tree.least(spec("c", size), without)
    assert least == twin.least(size, without)
    assert (found is None) == (least == float("inf"))
    assert found is None or (found.id not in without and twin.known[found.id] == (found, least))


def test_search_among_ten_thousand_machines_examines_few(monkeypatch: pytest.MonkeyPatch) -> None:
    tree, examined = RoomTree(), 0
    machines = [machine(f"m{number}", 2) for number in range(10_000)]
    for number, each in enumerate(machines):
        each.given = 0.0 if number == 7_000 else each.capacity
        tree.put(each, number / 10_000)

    def has_room(self: Machine, wanted: object) -> bool:
        nonlocal examined
        examined += 1
        return self is machines[7_000]

    monkeypatch.setattr(Machine, "has_room", has_room)
    assert tree.first(spec("c")) is tree.least(spec("c"))[1] is machines[7_000]
    assert examined == 2

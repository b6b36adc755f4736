"""Tests of the room tree: it finds a machine with free capacity without examining each."""

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.master.balancers.room_tree import RoomTree
from engine.master.machine import Machine
from tests.support.engine.placing import machine, spec


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

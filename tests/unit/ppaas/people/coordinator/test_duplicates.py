"""Duplicates: identities at two positions that are one person, and two people who are not."""

from collections.abc import Sequence

import numpy as np
import pytest

from ppaas.people.coordinator.duplicates import Duplicates
from ppaas.people.coordinator.people_table import PeopleTable

Pairs = list[tuple[int, int]]


def found(apart: Sequence[tuple[float, float]], speed: float = 0.0, deviation: float = 0.1) -> Pairs:
    """Return the duplicates after 4 s, of pairs with these differences [m], each side seen by a robot of its own."""
    duplicates, pairs = Duplicates(), []
    for step in range(20):
        table, now = PeopleTable(), 0.2 * step
        for number, (x, y) in enumerate(apart):
            at = np.array([[speed * now, 10.0 * number], [speed * now + x, 10.0 * number + y]])
            table.begin(at, np.tile(0.01 * np.eye(2), (2, 1, 1)), now)
        for row, person in enumerate(table.rows):
            person.seen_by, person.deviation = {"ab"[row % 2]: "torso"}, deviation
        pairs = duplicates.find(table, now, lambda rows: [True] * len(rows))
    return pairs


def test_two_who_stand_a_metre_apart_are_not_one_person_as_the_robots_know_where_they_are() -> None:
    assert found([(0.9, 0.0)]) == []


@pytest.mark.parametrize(
    ("apart", "speed", "deviation"),
    [([(0.9, 0.0)], 0.5, 0.1), ([(0.9, 0.0)], 0.0, 0.6), ([(0.2, 0.0)], 0.0, 0.1)],
    ids=["they walk with the same difference", "the robots are that uncertain", "there is no room for two"],
)
def test_two_identities_are_one_person_if(apart: list[tuple[float, float]], speed: float, deviation: float) -> None:
    assert found(apart, speed, deviation) == [(1, 2)]


def test_two_pairs_with_the_same_difference_are_two_people_though_they_stand() -> None:
    assert sorted(found([(0.9, 0.3), (0.9, 0.3)])) == [(1, 2), (3, 4)]

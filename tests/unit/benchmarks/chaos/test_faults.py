"""Kinds of faults and their order."""

import itertools
from collections import Counter
from random import Random

from benchmarks.chaos.faults import OF_MORE, OF_ONE_MACHINE, FaultKind, deck


def first(count: int, seed: int, machines: int) -> list[FaultKind]:
    return list(itertools.islice(deck(Random(seed), machines), count))


def test_the_order_of_faults_depends_only_on_the_seed() -> None:
    assert first(40, 1, 3) == first(40, 1, 3) != first(40, 2, 3)


def test_all_kinds_are_equally_frequent() -> None:
    kinds = (*OF_ONE_MACHINE, *OF_MORE)
    assert Counter(first(3 * len(kinds), 5, 2)) == Counter(3 * kinds)


def test_a_cloud_of_one_machine_has_no_faults_of_machines() -> None:
    assert set(first(100, 1, 1)) == set(OF_ONE_MACHINE)


def test_a_kind_is_described_in_words() -> None:
    assert str(FaultKind("fork server", "stop")) == "fork server, stopped"

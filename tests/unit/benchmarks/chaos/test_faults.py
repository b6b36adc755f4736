"""Kinds of faults and their order."""

import itertools
from collections import Counter
from random import Random

from benchmarks.chaos.faults import (
    LONGEST_STOP,
    OF_MORE,
    OF_ONE_MACHINE,
    OF_TRAFFIC,
    OF_TWO_MASTERS,
    CloudSize,
    FaultKind,
    deck,
    pauses,
)
from engine.leadership.candidate import LeaseTiming

TIMING = LeaseTiming()


def first(count: int, seed: int, machines: int, **has: bool) -> list[FaultKind]:
    return list(itertools.islice(deck(Random(seed), CloudSize(machines, **has)), count))


def test_the_order_of_faults_depends_only_on_the_seed() -> None:
    assert first(40, 1, 3) == first(40, 1, 3) != first(40, 2, 3)


def test_all_kinds_are_equally_frequent() -> None:
    kinds = (*OF_ONE_MACHINE, *OF_MORE, *OF_TWO_MASTERS)
    assert Counter(first(3 * len(kinds), 5, 2, standby=True)) == Counter(3 * kinds)


def test_traffic_nodes_fail_too_where_robots_are_in_traffic() -> None:
    kinds = (*OF_ONE_MACHINE, *OF_TRAFFIC)
    assert Counter(first(2 * len(kinds), 5, 1, traffic=True)) == Counter(2 * kinds)
    assert str(OF_TRAFFIC[0]) == "traffic node, killed"


def test_a_cloud_of_one_machine_has_no_faults_of_machines() -> None:
    assert set(first(100, 1, 1)) == set(OF_ONE_MACHINE)


def test_only_a_master_with_a_standby_stays_stopped_until_it_is_replaced() -> None:
    [alone] = pauses("master", standby=False)
    assert max(pauses("master", standby=True)) > TIMING.patience >= alone
    assert pauses("router", standby=True) == pauses("router", standby=False) == (LONGEST_STOP,)


def test_a_kind_is_described_in_words() -> None:
    assert str(FaultKind("fork server", "stop")) == "fork server, stopped"

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.specs import cores
from ppaas.errors import InvalidParameter, QuotaExceeded

sizes = st.floats(0.01, 64.0)


@pytest.mark.parametrize(("size", "threads", "width"), [(0.25, 1, 1), (1, 1, 1), (1.5, 1, 2), (2, 2, 2), (2.75, 2, 3)])
def test_threads_are_whole_cores_and_cpus_cover_the_size(size, threads, width):
    assert (cores.threads(size), cores.width(size)) == (threads, width)


@given(sizes)
def test_a_container_never_has_more_threads_than_cpus(size):
    assert 1 <= cores.threads(size) <= cores.width(size)


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf, -math.inf])
def test_an_invalid_size_is_refused(size):
    with pytest.raises(InvalidParameter, match="positive number of cores"):
        cores.check(size, 4)


def test_a_size_above_the_machine_is_refused():
    with pytest.raises(QuotaExceeded, match=r"2\.5 cores does not fit a machine of 2"):
        cores.pick(2.5, (0, 1), {})


def test_machine_oversubscribes_cores_but_not_memory():
    assert cores.capacity(4, 8 << 30) == 16.0
    assert cores.capacity(4, 8 << 30, 1.0) == 4.0
    assert cores.capacity(4, 1 << 30) == 8.0
    assert cores.memory(8.0) == 1 << 30


def test_the_least_used_cpus_are_picked():
    assert cores.pick(1.5, (3, 1, 2, 0), {0: 0.5, 1: 2.0, 3: 0.25}) == (2, 3)


def test_idle_cpus_are_picked_from_the_lowest():
    assert cores.pick(2, (7, 5, 6), {}) == (5, 6)


def test_used_cores_are_counted_per_cpu():
    assert cores.used([(1.5, (0, 1)), (0.5, (1,))]) == {0: 0.75, 1: 1.25}


@given(st.lists(st.floats(0.1, 1.0), max_size=40), st.integers(1, 8))
def test_small_containers_are_spread_evenly_over_the_cpus(given_sizes, cpus):
    placed: list[tuple[float, tuple[int, ...]]] = []
    for size in given_sizes:
        placed.append((size, cores.pick(size, range(cpus), cores.used(placed))))
    load = cores.used(placed)
    all_loads = [load.get(cpu, 0.0) for cpu in range(cpus)]
    assert max(all_loads) - min(all_loads) <= 1.0 + 1e-9
    assert sum(all_loads) == pytest.approx(sum(given_sizes))

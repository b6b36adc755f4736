"""Memory of searches: values that are not reset, and a queue that pops cells by bucket."""

from hypothesis import given
from hypothesis import strategies as st

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.grid import search_memory as module
from ppaas.planners.grid.kernels.bucket_ring import BUCKET, FREE, SIZE, SLOTS, USED, empty, pop, push
from ppaas.planners.grid.search_memory import BucketRing, ReusableValues
from ppaas.planners.watch import proceed


def test_the_values_of_a_search_are_below_those_of_earlier_searches():
    fresh, least = ReusableValues((4,), 11), 0
    for _ in range(5):
        base = fresh.begin()
        assert base % 2 == 0
        assert base + 11 <= least
        assert (fresh.values > base + 10).all()
        fresh.values[:2] = base, base + 10
        least = base


def test_array_is_replaced_when_the_range_is_used_up(monkeypatch):
    monkeypatch.setattr(module, "LOWEST", -30)
    fresh = ReusableValues((3,), 10)
    bases = []
    for _ in range(7):
        bases.append(fresh.begin())
        assert (fresh.values > bases[-1] + 9).all()
        fresh.values[:] = bases[-1]
    assert bases == [-10, -20, -30, -10, -20, -30, -10]


# Distances of keys: small ones, and ones that leave whole words of marks empty, up to the largest allowed.
STEPS = st.one_of(st.integers(0, 3), st.integers(0, 5_000), st.integers(0, SLOTS // 2))
OPERATIONS = st.lists(st.one_of(STEPS, st.none()), max_size=200)


@bare
def put(heads, marks, pool, state, cell, key):
    push(heads, marks, pool, state, cell, key)


@bare
def take(heads, marks, pool, state):
    return pop(heads, marks, pool, state)


def arrays(ring):
    return ring.heads, ring.marks, ring.pool, ring.state


@given(OPERATIONS, st.integers(1, 1 << 30), st.integers(0, 1 << 12))
def test_cells_are_popped_by_bucket_in_lifo_order(operations, span, grain):
    ring = BucketRing(span, grain, 200, 0)
    width = 1 << int(ring.state[1])
    inside: dict[int, list[int]] = {}
    lowest = 0
    for cell, step in enumerate(operations):
        if step is not None:
            bucket = lowest + step * span // (SLOTS // 2) // width
            put(*arrays(ring), cell, bucket * width)
            inside.setdefault(bucket, []).append(cell)
            continue
        taken = take(*arrays(ring))
        if not inside:
            assert taken == -1
            continue
        lowest = min(inside)
        assert taken == inside[lowest].pop()
        assert ring.state[BUCKET] == lowest
        if not inside[lowest]:
            del inside[lowest]
    assert ring.state[SIZE] == sum(map(len, inside.values()))


@given(st.lists(STEPS, max_size=50), st.integers(0, 1 << 40))
def test_a_cleared_queue_is_empty(steps, key):
    ring = BucketRing(SLOTS // 2, 1, 50, 0)
    for cell, step in enumerate(steps):
        put(*arrays(ring), cell, step)
    empty(ring.heads, ring.marks, ring.state, key)
    assert not ring.heads.any()
    assert not ring.marks.any()
    assert ring.state[[SIZE, USED, FREE]].tolist() == [0, 0, 0]
    put(*arrays(ring), 7, key + 3)
    assert take(*arrays(ring)) == 7


def test_growing_the_queue_keeps_its_entries():
    ring = BucketRing(100, 1, 0, 0)
    space = len(ring.pool) - 1
    for cell in range(space):
        put(*arrays(ring), cell, 5)
    ring.grow(proceed)
    assert len(ring.pool) == 2 * (space + 1)
    put(*arrays(ring), space, 4)
    assert [take(*arrays(ring)) for _ in range(space + 2)] == [space, *range(space - 1, -1, -1), -1]

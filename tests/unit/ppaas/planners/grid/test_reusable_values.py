from ppaas.planners.grid import search_memory as module
from ppaas.planners.grid.search_memory import ReusableValues


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

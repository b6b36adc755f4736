from ppaas.planners.grid import reusable_values as module
from ppaas.planners.grid.reusable_values import FreshValues


def test_what_a_search_writes_is_less_than_all_that_was_written_before():
    fresh, least = FreshValues((4,), 11), 0
    for _ in range(5):
        base = fresh.begin()
        assert base % 2 == 0
        assert base + 11 <= least
        assert (fresh.values > base + 10).all()
        fresh.values[:2] = base, base + 10
        least = base


def test_when_the_numbers_are_used_up_it_begins_again_with_zeros(monkeypatch):
    monkeypatch.setattr(module, "LOWEST", -30)
    fresh = FreshValues((3,), 10)
    bases = []
    for _ in range(7):
        bases.append(fresh.begin())
        assert (fresh.values > bases[-1] + 9).all()
        fresh.values[:] = bases[-1]
    assert bases == [-10, -20, -30, -10, -20, -30, -10]

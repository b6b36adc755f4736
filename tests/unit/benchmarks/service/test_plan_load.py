"""Figures of the load of plans."""

import itertools

import pytest

from benchmarks.service.plan_load import PAIRS, SMALL, Costs, Way, figures, pairs_of, planning_time, ways_of
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap


@pytest.fixture(scope="module")
def grid() -> GridMap:
    return warehouse(seed=1, width=64.0, height=40.0)


def test_costs_are_set_beside_the_echo() -> None:
    way = Way("plans", "/", lambda: iter(()), whole=3.0, endpoint=2.0, rate=1000.0)
    cloud, echo = Costs(1.2, 0.5, 0.6, 900.0, 5000), Costs(0.3, 0.3, 0.0, 4000.0, 5000)
    found = {figure.name.partition(": ")[2]: figure for figure in figures(way, 64, cloud, echo, 0.3)}
    assert {name: figure.value for name, figure in found.items()} == {
        "CPU time": 1.2,
        "FastAPI, echo": 0.3,
        "beside it": 4.0,
        "endpoint beside it": 1.67,
        "beside it, beyond planning": 3.0,
        "rate": 900,
    }
    assert [found[name].kept for name in ("beside it", "endpoint beside it", "rate")] == [False, True, False]
    assert len(figures(way, 1, cloud, echo, None)) == 4


def test_each_request_for_a_path_is_a_new_one(grid: GridMap) -> None:
    pairs = pairs_of(grid, *SMALL)
    assert len(pairs) == PAIRS
    assert planning_time(grid, pairs[:1])() > 0.0
    way = ways_of(grid)[0]
    bodies = list(itertools.islice(way.bodies(), 3 * PAIRS))
    assert len({str(body["start"]) for body in bodies}) == len(bodies)
    assert {str(body["start"][:2]) for body in bodies} == {str([*start]) for start, _ in pairs}  # type: ignore[index]

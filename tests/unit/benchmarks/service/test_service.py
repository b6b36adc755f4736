"""Parts of the service bench: first use, fleets, load by plans, and their reuse."""

import itertools

import numpy as np
import pytest

from benchmarks.service.first_use import _figures
from benchmarks.service.fleet import Trial, search
from benchmarks.service.metrics import COST_LIMIT, cost_of, is_watched
from benchmarks.service.plan_load import PAIRS, SMALL, Costs, Way, figures, pairs_of, planning_time, ways_of
from benchmarks.service.plan_reuse import TIMES, _sample, _Taken
from benchmarks.service.plan_reuse import _figures as _reuse_figures
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap


def test_figures_are_named_by_what_a_user_waits_for() -> None:
    figures = _figures("with a wheel", {"up": 1.5, "jps": 2.0, "drives": 7.0, "lost": 0.0}, within_limits=True)
    assert [figure.name for figure in figures] == [
        "ppaas up, ready, with a wheel",
        "first path of jps, with a wheel",
        "first cmd_vel of a robot, with a wheel",
        "requests lost, with a wheel",
    ]
    assert all(figure.kept for figure in figures)


def test_a_lost_request_or_a_late_path_breaks_a_limit() -> None:
    figures = _figures("with a wheel", {"jps": 5.5, "drives": 8.5, "lost": 1.0}, within_limits=True)
    assert [figure.kept for figure in figures] == [False] * 3


def test_a_yardstick_has_no_limit() -> None:
    (figure,) = _figures("again", {"jps": 9.0}, yardstick=True)
    assert (figure.kept, figure.yardstick) == (None, True)


def trial(robots: int, gap: float, late: float = 0.0) -> Trial:
    return Trial(robots, np.full(100, gap), {"web": 0.25}, late, [])


@pytest.mark.parametrize("largest", [0, 1, 5, 8, 13, 16, 31, 64])
async def test_the_largest_fleet_within_the_limit_is_found(largest: int) -> None:
    async def drive(robots: int) -> Trial:
        return trial(robots, 0.05 if robots <= largest else 0.2)

    trials = await search(drive, first=8, most=64)
    assert [t.robots for t in trials] == sorted({t.robots for t in trials})
    assert max((t.robots for t in trials if t.good), default=0) == largest


async def test_each_fleet_size_is_tried_once_up_to_the_maximum() -> None:
    tried: list[int] = []

    async def drive(robots: int) -> Trial:
        tried.append(robots)
        return trial(robots, 0.05)

    await search(drive, first=2, most=5)
    assert tried == [2, 4, 5]


def test_a_world_that_falls_behind_fails_the_trial() -> None:
    assert trial(3, 0.05).good
    assert not trial(3, 0.05, late=0.5).good
    assert not Trial(3, np.zeros(0), {}, 0.0, []).good


def test_a_trial_describes_its_measurements() -> None:
    assert trial(3, 0.05).sentence().startswith("3 robots: gap p50 50, p99 50, most 50 ms; CPUs: web 0.25")


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


async def test_computed_and_reused_paths_are_sampled_separately() -> None:
    requests: list[bool] = []

    async def ask(reuse: bool) -> str:
        requests.append(reuse)
        return "reused" if reuse else "computed"

    taken = await _sample(ask, 3)
    assert requests == [False] * 4 + [True] * 3
    assert (len(taken.computed), len(taken.asked), dict(taken.origins)) == (3, 3, {"reused": 3})


def test_the_speed_up_is_reported_only_for_reused_paths() -> None:
    taken = _Taken([1.0, 2.0, 3.0], [0.1, 0.1, 0.4])
    taken.origins["reused"] = 3
    *_, sooner = _reuse_figures("navfn", taken)
    assert (sooner.value, sooner.unit, sooner.limit, sooner.kept) == (20.0, "×", TIMES, True)
    taken.origins["computed"] = 1
    assert [figure.unit for figure in _reuse_figures("navfn", taken)] == ["ms", "ms"]


def test_turns_with_and_without_metrics_are_in_balance() -> None:
    turns = [number for number in range(8) if is_watched(number)]
    assert (len(turns), sum(turns)) == (4, sum(range(8)) - sum(turns))


@pytest.mark.parametrize(("more", "kept"), [(1.0 + COST_LIMIT / 200.0, True), (1.0 + COST_LIMIT / 50.0, False)])
def test_metrics_that_cost_too_much_break_the_limit(more: float, kept: bool) -> None:
    plain = [1.0, 2.0, 4.0]
    figure = cost_of(plain, [each * more for each in plain], robots=6)
    assert figure.value == pytest.approx(100.0 * (more - 1.0)) and figure.kept is kept

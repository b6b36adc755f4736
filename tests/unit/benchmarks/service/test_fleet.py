"""The search for the largest fleet."""

import numpy as np
import pytest

from benchmarks.service.fleet import Trial, search


def trial(robots: int, gap: float, late: float = 0.0) -> Trial:
    return Trial(robots, np.full(100, gap), {"web": 0.25}, late, [])


@pytest.mark.parametrize("largest", [0, 1, 5, 8, 13, 16, 31, 64])
async def test_the_largest_fleet_that_is_in_time_is_found(largest: int) -> None:
    async def drive(robots: int) -> Trial:
        return trial(robots, 0.05 if robots <= largest else 0.2)

    trials = await search(drive, first=8, most=64)
    assert [t.robots for t in trials] == sorted({t.robots for t in trials})
    assert max((t.robots for t in trials if t.good), default=0) == largest


async def test_each_number_is_tried_once_and_no_more_than_allowed() -> None:
    tried: list[int] = []

    async def drive(robots: int) -> Trial:
        tried.append(robots)
        return trial(robots, 0.05)

    await search(drive, first=2, most=5)
    assert tried == [2, 4, 5]


def test_a_world_that_falls_behind_is_not_in_time_however_even_its_commands() -> None:
    assert trial(3, 0.05).good
    assert not trial(3, 0.05, late=0.5).good
    assert not Trial(3, np.zeros(0), {}, 0.0, []).good


def test_a_trial_says_what_it_measured() -> None:
    assert trial(3, 0.05).sentence().startswith("3 robots: gap p50 50, p99 50, most 50 ms; CPUs: web 0.25")

"""The search for the largest fleet."""

import numpy as np
import pytest

from benchmarks.service.fleet import Trial, search


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

"""Floors of a drive, by heights that are noisy and drift with the weather."""

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.floors.levels import levels_of


def ride(*floors: float, seconds: float = 40.0, speed: float = 0.7) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times and heights of a robot that stays on floors and rides between them."""
    heights = [np.full(int(10 * seconds), floors[0])]
    for before, after in itertools.pairwise(floors):
        steps = int(10 * abs(after - before) / speed)
        heights += [np.linspace(before, after, steps), np.full(int(10 * seconds), after)]
    joined = np.concatenate(heights)
    return 0.1 * np.arange(len(joined)), joined


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("drift", [0.0, 0.004, -0.004])
def test_floors_are_found_although_the_weather_changes(noise: float, drift: float) -> None:
    stamps, heights = ride(0.0, 3.4, 6.8, 0.0, 3.4)
    random = np.random.default_rng(3)
    seen = heights + drift * stamps + random.normal(0.0, noise, len(stamps))
    levels = levels_of(stamps, seen)
    assert [level.elevation for level in levels] == pytest.approx([0.0, 3.4, 6.8], abs=0.35)
    assert [len(level.spans) for level in levels] == [2, 2, 1]
    for level, height in zip(levels, (0.0, 3.4, 6.8), strict=True):
        covered = level.covers(stamps)
        assert np.abs(heights[covered] - height).max() < 0.7
        assert covered.sum() > 0.8 * (heights == height).sum()


def test_a_drive_on_one_floor_has_one_whatever_the_air_does() -> None:
    stamps = np.arange(0.0, 600.0, 0.5)
    [level] = levels_of(stamps, 3.0 * np.sin(stamps / 300.0))
    assert level.elevation == 0.0 and level.covers(np.array([-1e9, 300.0, 1e9])).all()


def test_the_order_of_messages_does_not_count_and_cellars_are_floors() -> None:
    stamps, heights = ride(0.0, -3.0, 0.0)
    order = np.random.default_rng(1).permutation(len(stamps))
    levels = levels_of(stamps[order], heights[order])
    assert [level.elevation for level in levels] == pytest.approx([0.0, 3.0], abs=0.01)
    assert [len(level.spans) for level in levels] == [1, 2]


@pytest.mark.parametrize("heights", [[], [np.nan, 0.0], list(np.arange(0.0, 400.0))])
def test_heights_that_show_no_floor_are_refused(heights: list[float]) -> None:
    with pytest.raises(InvalidInput):
        levels_of(np.arange(len(heights), dtype=float), np.array(heights))

"""What is told of the field of a grid."""

import numpy as np
import pytest
from rich.progress import Progress

from ppaas.errors import InvalidParameter
from robots.bench.planners import field, grids


def test_every_number_of_threads_has_its_seconds_and_all_cells_are_counted() -> None:
    grid = grids.random(40, 30.0)
    with Progress(disable=True) as progress:
        told = field.measure(grid, None, [1, 2], progress, runs=2)
    assert told["cells"] == 1600
    reached = np.isfinite(field.grow(grid.costmap, tuple(told["goal"]), 1).field.values()).sum()
    assert told["reached"] == reached > 800
    for n in ("1", "2"):
        assert told["seconds"][n] == pytest.approx(told["setup_seconds"][n] + told["growth_seconds"][n])
        assert told["ns_per_cell"][n] == pytest.approx(told["seconds"][n] / reached * 1e9)
        assert told["seconds"][n] > 0.0
    assert told["compile_seconds"] >= 0.0


@pytest.mark.parametrize("threads", [[], [0], [1, -1]])
def test_a_field_takes_a_thread(threads: list[int]) -> None:
    with Progress(disable=True) as progress, pytest.raises(InvalidParameter):
        field.measure(grids.empty(4), None, threads, progress)


def test_the_farthest_cell_is_the_dearest() -> None:
    assert field.farthest(field.grow(grids.empty(9).costmap, (1, 1), 1).field) == (8, 8)

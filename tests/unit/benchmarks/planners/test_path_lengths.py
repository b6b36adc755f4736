"""Paths of increasing length, in this process and in a container."""

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.planners import grids, path_lengths
from ppaas.maps.generate import warehouse

SMALL = warehouse(seed=1, width=15.0, height=8.0)


def test_path_lengths_grow_in_equal_steps_to_nearly_the_longest() -> None:
    questions = path_lengths.questions(grids.empty(101).costmap, points=4)
    assert len({question.goal for question in questions}) == 1
    # From corner to corner of a square of 5 m it is 7.07 m.
    np.testing.assert_allclose([question.length for question in questions], np.arange(1, 5) * 7.07 / 4, atol=0.08)


async def test_every_number_of_threads_has_its_curve() -> None:
    with Progress(disable=True) as progress:
        result = await path_lengths.measure_locally(grids.empty(64).costmap, [1, 2], progress)
    assert list(result["seconds"]) == ["dijkstra, 1 thread", "dijkstra, 2 threads"]
    assert all(len(curve) == len(result["length_m"]) == path_lengths.POINTS for curve in result["seconds"].values())
    title, lines, _, _ = path_lengths.chart(result)
    assert "4,096 cells" in title
    assert lines[0].points[0] == (result["length_m"][0], 1e3 * result["seconds"]["dijkstra, 1 thread"][0])


@pytest.mark.journey
async def test_a_container_with_many_cores_is_timed_from_request_to_answer() -> None:
    with Progress(disable=True) as progress:
        result = await path_lengths.measure(SMALL, 2, progress, points=2)
    curves = result["seconds"]
    assert set(curves) == {
        "dijkstra, 1 thread", "dijkstra, 2 threads", "dijkstra, container of 2 cores, request to answer",
        "navfn, 1 thread",
    }  # fmt: skip
    assert all(0.0 < seconds < float("inf") for curve in curves.values() for seconds in curve)

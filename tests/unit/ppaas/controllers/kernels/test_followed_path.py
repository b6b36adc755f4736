"""The kernels for plans give the same numbers as their twin, to the last bit."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.controllers.kernels import followed_path as kernels
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from tests.reference.driving import controllers

coordinates = st.floats(-3.0, 3.0).map(lambda value: round(value, 2))
places = st.tuples(coordinates, coordinates)
grids = st.builds(
    GridInfo, st.sampled_from((0.05, 0.1)), st.integers(5, 60), st.integers(5, 60),
    st.builds(Pose2D, coordinates, coordinates, st.floats(-3.0, 3.0)),
)  # fmt: skip

Plan = tuple[NDArray[np.float64], NDArray[np.float64]]


@st.composite
def plans(draw: st.DrawFn) -> Plan:
    """Draw a plan of several corners; some points are equal, and some plans have one."""
    corners = np.array(draw(st.lists(places, min_size=1, max_size=5)))
    parts = [corners[:1]]
    for begin, end in itertools.pairwise(corners):
        parts.append(begin + np.linspace(0.0, 1.0, draw(st.integers(1, 40)))[:, None] * (end - begin))
    points = np.concatenate(parts)
    steps = np.diff(points, axis=0)
    return points, np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))


@given(plan=plans(), robot=st.lists(places, min_size=1, max_size=4))
def test_robots_are_located_as_by_the_twin(plan: Plan, robot: list[tuple[float, float]]) -> None:
    reached = 0
    for x, y in robot:
        expected = controllers.locate(*plan, reached, x, y)
        reached = kernels.locate(*plan, reached, x, y)
        assert reached == expected


@given(plan=plans(), s=st.floats(-1.0, 30.0))
def test_points_of_a_plan_are_those_of_the_twin(plan: Plan, s: float) -> None:
    for at in (s, *plan[1][:3].tolist(), float(plan[1][-1])):
        assert kernels.point_at(*plan, at) == controllers.point_at(*plan, at)


@given(plan=plans(), reached=st.integers(0, 1 << 16), distance=st.floats(0.0, 6.0), info=grids)
def test_the_plan_ahead_is_that_of_the_twin(plan: Plan, reached: int, distance: float, info: GridInfo) -> None:
    reached %= len(plan[0])
    points, remaining = kernels.points_ahead(
        *plan, reached, distance, tuple(map(float, info.origin)), info.resolution, info.shape
    )
    expected, left = controllers.points_ahead(*plan, reached, distance, info)
    np.testing.assert_array_equal(points, expected)
    np.testing.assert_array_equal(remaining, left)

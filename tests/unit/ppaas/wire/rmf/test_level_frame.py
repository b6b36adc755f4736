"""Frames of Open-RMF: what fits, what is left, and what cannot be fitted."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.wire.rmf.level_frame import LevelFrame

ROBOT = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (2.0, 7.0)]
numbers = st.floats(-100.0, 100.0)


@given(st.floats(0.05, 20.0), st.floats(-3.1, 3.1), numbers, numbers, st.tuples(numbers, numbers, st.floats(-3.1, 3.1)))
def test_a_turned_scaled_and_shifted_frame_is_found(
    scale: float, rotation: float, x: float, y: float, pose: tuple[float, float, float]
) -> None:
    true = LevelFrame(scale, rotation, x, y)
    found = LevelFrame.of([true.to_rmf(Pose2D(*place))[:2] for place in ROBOT], ROBOT)
    assert (found.scale, found.x, found.y) == pytest.approx((scale, x, y), abs=1e-6)
    assert math.cos(found.rotation - rotation) == pytest.approx(1.0)
    assert found.residual == pytest.approx(0.0, abs=1e-6)
    there = found.to_rmf(Pose2D(*pose))
    back = found.from_rmf(there)
    assert back[:2] == pytest.approx(pose[:2], abs=1e-6)
    assert math.cos(back.theta - pose[2]) == pytest.approx(1.0)


def test_a_quarter_turn_by_hand() -> None:
    found = LevelFrame.of([(1.0, 2.0), (1.0, 4.0)], [(0.0, 0.0), (1.0, 0.0)])
    assert (found.scale, found.rotation, found.x, found.y) == pytest.approx((2.0, math.pi / 2, 1.0, 2.0))
    assert found.to_rmf(Pose2D(0.0, 1.0, 0.0)) == pytest.approx((-1.0, 2.0, math.pi / 2))


def test_the_residual_is_what_is_left_at_the_points() -> None:
    moved = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (2.0, 8.0)]
    found = LevelFrame.of(moved, ROBOT)
    left = [math.dist(found.to_rmf(Pose2D(*place))[:2], there) for place, there in zip(ROBOT, moved, strict=True)]
    assert found.residual == pytest.approx(math.sqrt(sum(distance**2 for distance in left) / 4))
    assert 0.1 < found.residual < 0.5


@pytest.mark.parametrize(
    ("rmf", "robot", "text"),
    [
        ([(0.0, 0.0)], [(0.0, 0.0)], "two or more"),
        ([(0.0, 0.0), (1.0, 1.0)], [(0.0, 0.0)], "2 are of RMF and 1 of the robot"),
        ([(0.0, 0.0), (math.nan, 1.0)], [(0.0, 0.0), (1.0, 1.0)], "finite"),
        ([(1.0, 1.0), (1.0, 1.01)], [(0.0, 0.0), (5.0, 1.0)], "at one place"),
        ([(0.0, 0.0), (5.0, 1.0)], [(3.0, 3.0), (3.0, 3.0)], "at one place"),
        ([(1.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (-1.0, 0.0)], [(1.0, 0.0), (-1.0, 0.0), (-1.0, 0.0), (1.0, 0.0)], "fit"),
    ],
)
def test_points_that_give_no_frame_are_refused(
    rmf: list[tuple[float, float]], robot: list[tuple[float, float]], text: str
) -> None:
    with pytest.raises(InvalidInput, match=text):
        LevelFrame.of(rmf, robot)

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.moving_obstacles import MovingObstacle, swept_discs

FAR = (50.0, 50.0, 0.2)
movers = st.builds(
    MovingObstacle,
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.floats(0.1, 0.5),
)


@given(mover=movers, seconds=st.floats(0.0, 2.0), at=st.floats(0.0, 1.0))
def test_the_discs_cover_the_swept_area(mover, seconds, at):
    discs = list(swept_discs([mover], seconds, FAR))
    there = mover.after(at * seconds)
    assert min(math.hypot(there.x - x, there.y - y) for x, y, _ in discs) <= 0.5 * mover.radius + 1e-9
    assert discs[0] == (mover.x, mover.y, mover.radius)
    assert {radius for *_, radius in discs} == {mover.radius}


@given(mover=movers, seconds=st.floats(0.0, 2.0))
def test_future_discs_do_not_touch_the_robot(mover, seconds):
    robot = (0.0, 0.0, 0.2)
    for x, y, radius in list(swept_discs([mover], seconds, robot))[1:]:
        assert math.hypot(x, y) > radius + 0.2


@pytest.mark.parametrize("still", [MovingObstacle(1.0, 2.0, 0.0, 0.0, 0.3), MovingObstacle(1.0, 2.0, 1.0, 0.0, 0.0)])
def test_obstacle_at_rest_or_without_radius_is_one_disc(still):
    assert list(swept_discs([still], 1.0, FAR)) == [(1.0, 2.0, still.radius)]

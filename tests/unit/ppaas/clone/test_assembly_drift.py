"""A whole clone drives a Turtlebot of the simulator whose odometry drifts, on a manual clock."""

import pytest

from ppaas.maps.generate import office
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.nav_msgs import Odometry
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.places import free_pose, reachable_pose
from tests.support.world.simulated_world import SimulatedWorld


@pytest.mark.parametrize("seed", [0, 1])
def test_amcl_corrects_odometry_that_drifts_three_times_as_fast(seed: int) -> None:
    grid = office(seed=1, width=12.0, height=10.0)
    start = free_pose(grid, seed=3)
    world = SimulatedWorld(grid, start, drift=3.0, seed=seed)
    driving = ClosedLoop(world)
    drift: list[float] = []

    def note_drift(_: str, message: object) -> None:
        assert isinstance(message, Odometry)
        drift.append(world.pose.distance_to(start @ message.pose.pose.planar()))

    driving.graph.tap("odom", note_drift)
    for goal in (reachable_pose(grid, start, seed=4, at_least=4.0), start):
        driving.send_goal(goal)
        driving.run(90.0)
        assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert drift[0] < 0.05, "odometry begins at the start"
    assert max(drift) > 0.15, "the drift is real"
    assert driving.worst < max(drift) and driving.worst <= 0.25
    assert world.touched == 0

"""A robot in a blocked corridor: all recovery behaviours are tried in order, and any of them may succeed."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

RADIUS = 0.18
START, GOAL = Pose2D(1.8, 0.8, 0.0), Pose2D(5.0, 0.8, 0.0)
CRATE = (3.2, 0.0, 3.5, 1.6)
CLOSET = [(0.0, 0.0, 1.5, 1.6)]

IN_ORDER = ["conservative_reset", "rotate_recovery", "back_up", "wait", "aggressive_reset"]
PARAMETERS = {
    "move_base": {
        "planner_patience": 0.3,
        "planner_frequency": 5.0,
        "recovery_behaviors": [
            {"name": "conservative_reset", "type": "clear_costmap_recovery/ClearCostmapRecovery"},
            {"name": "rotate_recovery", "type": "rotate_recovery/RotateRecovery"},
            {"name": "back_up", "type": "nav2_behaviors/BackUp"},
            {"name": "wait", "type": "nav2_behaviors/Wait"},
            {"name": "aggressive_reset", "type": "clear_costmap_recovery"},
        ],
    },
    "rotate_recovery": {"max_rotational_vel": 2.5},
    "wait": {"wait_duration": 1.0},
    "aggressive_reset": {"reset_distance": 0.0},
}


class Corridor:
    """The loop with the status texts of Move Base; the crate is removed when a given behaviour has ended."""

    def __init__(self, *, leaves_after: str = "", boxes=(), pose: Pose2D = START) -> None:
        self.driving = ClosedLoop(World(walled_map(6.4, 1.6, list(boxes)), pose, beams=360), parameters=PARAMETERS)
        self.texts: list[str] = []
        self.tried: list[str] = []
        self.backwards: set[str] = set()
        self._leaves_after = leaves_after
        self.driving.graph.tap("move_base/status", self._on_status)
        self.driving.graph.tap("cmd_vel", self._on_velocity)
        for _ in range(6):
            self.driving.step()

    def _on_status(self, _: str, message: GoalStatusArray) -> None:
        text = message.status_list[-1].text if message.status_list else ""
        if self.texts[-1:] == [text]:
            return
        before = self.texts[-1] if self.texts else ""
        self.texts.append(text)
        if text.startswith("recovering by "):
            self.tried.append(text.split()[2].rstrip(":"))
        elif before.startswith("recovering by ") and self.tried[-1] == self._leaves_after:
            self.put_crate(there=False)

    def _on_velocity(self, _: str, command) -> None:
        if command.linear.x < 0.0:
            self.backwards.add(self.tried[-1])

    def put_crate(self, *, there: bool) -> None:
        cells = self.driving.world.grid.data.copy()
        fill(cells, self.driving.world.grid.info, CRATE)
        self.driving.world.truth[cells != self.driving.world.grid.data] = there

    def block_and_drive(self) -> None:
        self.put_crate(there=True)
        self.driving.send_goal(GOAL)
        self.driving.run(90.0)


@pytest.mark.parametrize("last", IN_ORDER)
def test_robot_arrives_if_a_recovery_clears_the_corridor(last):
    corridor = Corridor(leaves_after=last)
    corridor.block_and_drive()
    assert corridor.tried == IN_ORDER[: IN_ORDER.index(last) + 1]
    assert corridor.driving.last_status() is Status.SUCCEEDED, corridor.driving.results[-1].status.text
    assert corridor.driving.world.pose.distance_to(GOAL) < 0.2
    assert corridor.driving.clearance > RADIUS
    assert corridor.backwards == ({"back_up"} if "back_up" in corridor.tried else set())


def test_goal_is_aborted_after_trying_the_recoveries_in_order():
    corridor = Corridor()
    corridor.block_and_drive()
    assert corridor.tried == IN_ORDER
    assert corridor.driving.last_status() is Status.ABORTED
    text = corridor.driving.results[-1].status.text
    assert text.startswith("Failed to find a valid plan. Even after executing recovery behaviors. no free path")
    assert (corridor.driving.command.linear.x, corridor.driving.command.angular.z) == (0.0, 0.0)
    assert corridor.driving.clearance > RADIUS


def test_robot_does_not_back_up_into_a_wall():
    corridor = Corridor(boxes=CLOSET)
    corridor.block_and_drive()
    assert corridor.tried == IN_ORDER
    assert "back_up failed: the space behind is not free after 0.00 m of 0.3 m" in corridor.texts
    assert not corridor.backwards


def test_goal_cancelled_during_a_recovery_stops_the_robot():
    corridor = Corridor()
    corridor.put_crate(there=True)
    corridor.driving.send_goal(GOAL)
    while "back_up" not in corridor.backwards:
        corridor.driving.step()
    corridor.driving.graph.inject("move_base/cancel", GoalID())
    assert corridor.driving.last_status() is Status.PREEMPTED
    assert corridor.driving.command.linear.x == 0.0

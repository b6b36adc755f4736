"""Surroundings of a robot: its last scans are marked again after a reset of its costmaps."""

import pytest

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleState, TrackedPerson
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.transforms.planar import transform_message
from tests.support.world.closed_loop import PERIOD, ClosedLoop
from tests.support.world.planar_world import World, error_of, fill, walled_map
from tests.support.world.rooms import room
from tests.support.world.simulated_world import SimulatedWorld

START = Pose2D(1.0, 1.0, 0.0)
BOX = (2.0, 0.5, 2.2, 1.5)


class Reset:
    """A robot that has seen a box ahead, and whose costmaps were cleared since its last scan."""

    def __init__(self) -> None:
        self.driving = ClosedLoop(World(walled_map(6, 4, []), START))
        self.put_box(there=True)
        for _ in range(6):
            self.driving.step()
        self.around: Surroundings = self.driving.graph.nodes["move_base"]._surroundings
        assert self.sees_box()
        self.around.clear()
        assert not self.box_is_marked()

    def put_box(self, *, there: bool) -> None:
        cells = self.driving.world.grid.data.copy()
        fill(cells, self.driving.world.grid.info, BOX)
        self.driving.world.truth[cells != self.driving.world.grid.data] = there

    def box_is_marked(self) -> bool:
        seen = self.around.overlay(self.driving.layers.costmap)
        (top, left), (bottom, right) = seen.info.to_cells([BOX[:2], BOX[2:]])
        return bool((seen.data[top:bottom, left:right] == LETHAL_OBSTACLE).any())

    def sees_box(self, later: float = 0.0) -> bool:
        now = self.driving.clock() + later
        self.around.look_around(self.around.frames.in_map(), now)
        return self.box_is_marked()


@pytest.fixture
def reset() -> Reset:
    return Reset()


def test_last_scan_is_marked_again_after_a_reset(reset):
    assert reset.sees_box()


def test_obstacle_that_has_left_is_not_marked_again_after_the_next_scan(reset):
    reset.put_box(there=False)
    for _ in range(2):
        reset.driving.step()
    assert not reset.sees_box()


def test_scan_of_a_laser_that_has_fallen_silent_is_not_marked_again(reset):
    assert not reset.sees_box(later=1.5)


def test_last_scan_of_each_laser_is_marked_again(reset):
    assert reset.sees_box()
    behind = reset.driving.world.scan(reset.driving.clock())
    behind.header.frame_id = "base_link"
    quarter = len(behind.ranges) // 4
    behind.ranges[quarter : 3 * quarter] = [None] * (2 * quarter)
    reset.driving.sense("scan", behind)
    assert reset.sees_box()
    reset.around.clear()
    assert reset.sees_box()


# -- corrections of the pose -------------------------------------------------------------------------------------------


def corrected(reset: Reset, by: float) -> tuple[bool, bool]:
    """Return whether the box is marked where it was, and where it is after a correction of the pose along y [m]."""
    assert reset.sees_box()
    around, now = reset.around, reset.driving.clock()
    pose = around.frames.in_map()
    to_odom = Pose2D(pose.x, pose.y + by, pose.theta) @ around.frames.odometry().inverse()
    around.take("tf", TFMessage([transform_message("map", around.frames.odom, to_odom, Time.of(now))]), now, now)
    around.look_around(around.frames.in_map(), now)
    marked = around.seen().data == LETHAL_OBSTACLE
    column, row = round(BOX[0] / 0.05), round(1.0 / 0.05)
    cells = marked[:, column - 1 : column + 2].any(axis=1)
    top = row + round(0.5 / 0.05) + 1  # above the box, and within it after a correction
    return bool(cells[row - 4 : row].any()), bool(cells[top : top + 4].any())


def test_a_small_correction_keeps_what_was_seen(reset):
    assert corrected(reset, 0.1) == (True, False)


def test_a_large_correction_moves_the_last_scan_and_clears_the_rest(reset):
    assert corrected(reset, 0.6) == (False, True)


def test_people_of_the_coordinator_raise_costs_where_they_are_predicted(reset):
    around, graph = reset.around, reset.driving.graph
    people = [TrackedPerson(1, Point(2.0, 2.5), Point(0.5, 0.0), [0.0] * 4, group=1)]
    people.append(TrackedPerson(2, Point(3.0, 2.5), Point(0.5, 0.0), [0.0] * 4, group=1))
    graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 2, people))
    costs = []
    for later in (0.0, 0.8, 2.0):
        costmap = around.look_around(START, reset.driving.clock() + later)
        costs.append([int(costmap.data[costmap.info.cell_of(x, 2.5)]) for x in (2.5, 2.9, 3.4)])
    now, soon, late = costs
    assert now[0] > 150 and soon[1] > 150 and soon[2] > now[2]
    assert max(late) < 20, "the message is out of date"


def test_bodies_of_people_are_obstacles_that_are_not_remembered_and_slow_the_robot_down(reset):
    around, clock = reset.around, reset.driving.clock
    people = [
        TrackedPerson(1, Point(2.0, 2.5), Point(-0.5, 0.0), [0.0] * 4),
        TrackedPerson(2, Point(*START[:2]), Point(0.0, 0.0), [0.0] * 4),
    ]
    reset.driving.graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 2, people))
    costmap = around.look_around(START, clock())
    assert costmap.data[costmap.info.cell_of(2.0, 2.5)] == LETHAL_OBSTACLE
    assert costmap.data[costmap.info.cell_of(*START[:2])] < LETHAL_OBSTACLE, "the robot must be able to leave"
    assert any(walker.vx == -0.5 for walker in around.walkers(START, clock()))
    assert around.look_around(START, clock() + 3.0).data[costmap.info.cell_of(2.0, 2.5)] < LETHAL_OBSTACLE


def test_body_of_a_person_whom_no_camera_sees_any_more_is_an_obstacle_while_the_laser_sees_legs(reset):
    around, graph, clock = reset.around, reset.driving.graph, reset.driving.clock
    beside, empty = (1.8, 1.0), (1.5, 2.5)
    people = [TrackedPerson(k, Point(*at), Point(0.0, 0.0), [0.0] * 4) for k, at in ((1, (1.95, 1.0)), (2, empty))]

    def lethal():
        costmap = around.look_around(START, clock())
        return [costmap.data[costmap.info.cell_of(*at)] == LETHAL_OBSTACLE for at in (beside, empty)]

    graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 2, people))
    assert lethal() == [True, True]
    graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 0, []))
    assert lethal() == [True, False]
    reset.put_box(there=False)
    for _ in range(2):
        reset.driving.step()
        lethal()
    assert lethal() == [False, False]


def test_people_behind_a_wall_do_not_slow_the_robot_down():
    driving = ClosedLoop(World(walled_map(6, 4, [(2.0, 0.0, 2.2, 3.0)]), START))
    around: Surroundings = driving.graph.nodes["move_base"]._surroundings
    people = [TrackedPerson(k, Point(x, 1.0), Point(-0.5, 0.0), [0.0] * 4) for k, x in ((1, 1.8), (2, 2.7))]
    driving.graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 2, people))
    assert [walker.x for walker in around.walkers(START, driving.clock())] == [1.8]


START_OF_LOOP, GOAL = Pose2D(1.0, 1.0, 0.0), Pose2D(4.0, 3.0, 2.5)


def periods_of(controller: str, uplink: int, downlink: int) -> int:
    """Return the number of periods until the robot has reached the goal."""
    loop = ClosedLoop(SimulatedWorld(room(5.0, 4.0), START_OF_LOOP), base_local_planner=controller)
    loop.uplink, loop.downlink = uplink, downlink
    loop.run(1.0 + uplink * PERIOD)
    loop.send_goal(GOAL)
    before = len(loop.commands)
    loop.run(40.0)
    assert loop.last_status() is Status.SUCCEEDED
    apart, turned = error_of(loop.world.pose, GOAL)
    assert apart < 0.15 and turned < 0.25
    return len(loop.commands) - before


@pytest.mark.parametrize("controller", ["dwa", "pure_pursuit", "mppi"])
def test_a_goal_is_reached_in_spite_of_a_delay(controller: str) -> None:
    """Without prediction, `dwa` needs half as long again with 0.15 s, and does not arrive with 0.3 s."""
    fast = periods_of(controller, 0, 0)
    for uplink, downlink in ((3, 3), (6, 6)):
        assert periods_of(controller, uplink, downlink) < 1.5 * fast + 2 * (uplink + downlink)

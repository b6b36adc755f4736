"""Move Base in traffic: it drives as far as it is granted, and gives back what it does not need."""

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import MapPoint
from ppaas.messages.geometry_msgs import Pose, PoseStamped, Twist
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_servers import DockRobotActionGoal, DockRobotGoal, UndockRobotActionGoal
from ppaas.nodes.graph import Graph
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from tests.support.traffic.granted_robot import SPACING, GrantedRobot
from tests.support.world.planar_world import walled_map

LINE = ((0, 0), (1, 0), (2, 0), (3, 0))


def test_it_waits_for_a_traffic_node_and_says_so() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.run(2.0)
    assert robot.text == "waiting: the traffic of the map has not answered yet"
    assert robot.is_at(0, 0)
    assert (robot.report.goal_id, robot.report.way) == ("there", [])


def test_it_drives_to_the_end_of_its_grants_and_on_when_it_gets_more() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(*LINE[:2], goal_id="there", waits_for="tb2")
    robot.run(4.0)
    assert robot.is_at(1, 0) and not robot.results
    robot.grant(*LINE[:2], goal_id="there", waits_for="tb2")
    robot.run(0.5)
    assert robot.text == "waiting: tb2 goes first"
    assert (robot.report.ahead, robot.report.first) == (0, 1)
    robot.grant(*LINE, goal_id="there", at_goal=True)
    robot.run(8.0)
    assert robot.is_at(3, 0)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED]
    assert robot.report.goal_id == ""


def test_one_that_is_alone_drives_freely_until_the_traffic_node_is_silent() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(free=True)
    robot.run(1.0)
    assert robot.report.free and robot.command.linear.x > 0.0
    robot.run(4.0)
    assert not robot.report.free and robot.command.linear.x == 0.0
    assert robot.text == "waiting: the traffic of the map does not answer"


def test_a_refused_goal_is_aborted_with_the_reason() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(LINE[0], goal_id="there", refused="robot tb9 stands on it and does not move")
    robot.run(0.5)
    (result,) = robot.results
    assert result.status.status == Status.ABORTED
    assert "robot tb9 stands on it and does not move" in result.status.text


def test_a_refusal_of_an_earlier_goal_does_not_count() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0, "another")
    robot.grant(LINE[0], goal_id="there", refused="robot tb9 stands on it and does not move")
    robot.run(0.5)
    assert not robot.results


def test_one_without_a_goal_gives_way() -> None:
    robot = GrantedRobot()
    robot.grant(*LINE[:2])
    robot.run(5.0)
    assert robot.is_at(1, 0)
    assert robot.report.goal_id == "", "the goal of giving way is no goal of the robot"
    assert robot.report.ahead == 0


def test_it_drives_to_a_goal_beside_the_centre_of_its_cell_by_a_spur_and_back_when_it_is_told_to() -> None:
    robot = GrantedRobot()
    robot.send_goal(2, 0.4)
    assert robot.report.tolerance == 0.1
    spur = [robot.report.goal]
    robot.grant(*LINE[:3], goal_id="there", at_goal=True, spur=spur)
    robot.run(0.2)
    assert robot.report.spur == spur
    robot.run(12.0)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED]
    assert robot.is_at(2, 0.4)
    assert (robot.report.spur, robot.report.stray) == (spur, False)
    robot.grant(*LINE[:3], spur=spur)
    robot.run(2.0)
    assert robot.is_at(2, 0.4)
    robot.grant(*LINE[:3])
    robot.run(8.0)
    assert robot.is_at(2, 0) and not robot.report.spur
    assert robot.report.goal_id == ""


@pytest.mark.parametrize("off", [0.055, 0.07, 0.079])
def test_it_is_back_from_a_spur_as_near_to_the_centre_as_its_local_planner_drives(off: float) -> None:
    robot = GrantedRobot()
    robot.send_goal(2, 0.4)
    spur = [robot.report.goal]
    robot.grant(*LINE[:3], goal_id="there", at_goal=True, spur=spur)
    robot.run(12.0)
    robot.pose = Pose2D(1.0 + 2 * SPACING, 1.0 - off)
    robot.grant(*LINE[:3])
    robot.run(5.0)
    assert not robot.report.spur


def test_it_drives_back_from_a_spur_before_it_goes_on() -> None:
    robot = GrantedRobot()
    robot.send_goal(2, 0.4)
    robot.grant(*LINE[:3], goal_id="there", at_goal=True, spur=[robot.report.goal])
    robot.run(12.0)
    robot.send_goal(3, 0, "next")
    robot.grant(*LINE, goal_id="next", at_goal=True)
    robot.run(0.5)
    assert robot.report.spur
    while robot.report.spur:
        assert robot.pose.x < 1.0 + 2.3 * SPACING
        robot.run(0.1)
    assert robot.is_at(2, 0)
    robot.run(10.0)
    assert robot.is_at(3, 0) and not robot.report.spur
    assert len(robot.results) == 2


def test_it_stops_in_its_cell_if_it_sees_something_on_its_spur() -> None:
    robot = GrantedRobot()
    robot.send_goal(0, -1.35)
    robot.grant(LINE[0], goal_id="there", at_goal=True, spur=[robot.report.goal])
    robot.run(8.0)
    assert not robot.report.spur
    assert robot.is_at(0, 0)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED]


def test_a_goal_replaces_giving_way() -> None:
    robot = GrantedRobot()
    robot.grant(*LINE[:2])
    robot.run(0.5)
    robot.send_goal(3, 0)
    assert robot.report.goal_id == "there"
    robot.grant(*LINE, goal_id="there", at_goal=True)
    robot.run(8.0)
    assert robot.is_at(3, 0)


def test_a_cancelled_goal_stops_the_robot_which_gives_back_the_rest() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(*LINE, goal_id="there")
    robot.run(1.5)
    revision = robot.report.revision
    robot.cancel()
    robot.run(1.0)
    assert robot.command.linear.x == 0.0
    assert (robot.report.way, robot.report.goal_id) == ([], "")
    assert robot.report.revision > revision


def test_one_that_is_asked_gives_back_its_way_at_a_stop() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(*LINE, goal_id="there")
    robot.run(1.5)
    revision = robot.report.revision
    robot.grant(*LINE, goal_id="there", give_back=True)
    robot.run(1.0)
    assert (robot.report.revision, robot.report.way) == (revision + 1, [])
    assert not robot.results, "the goal stays"


def test_one_that_is_pushed_off_its_way_stops_and_begins_anew() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(*LINE, goal_id="there")
    robot.run(1.5)
    revision = robot.report.revision
    robot.pose = robot.pose._replace(y=robot.pose.y + 0.4)
    robot.run(0.2)
    assert robot.report.stray or robot.report.revision > revision
    robot.run(1.0)
    assert robot.command.linear.x == 0.0
    assert (robot.report.stray, robot.report.way) == (False, [])
    assert robot.report.revision == revision + 1


def test_one_that_is_stopped_gives_back_its_way_where_it_stands_and_asks_for_another_afterwards() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(*LINE, goal_id="there")
    robot.run(1.5)
    revision = robot.report.revision
    robot.graph.inject("stop/state", StopState(stopped=True, text="stopped by 'ann'"))
    robot.run(1.0)
    assert robot.command == Twist()
    assert (robot.report.aside, robot.report.way, robot.report.goal_id) == ("held", [], "there")
    assert robot.report.revision == revision + 1
    assert robot.text == "waiting: stopped by 'ann'"
    robot.graph.inject("stop/state", StopState())
    robot.run(0.5)
    assert (robot.report.aside, robot.report.revision, robot.results) == ("", revision + 2, [])
    robot.grant_from_here(2, goal_id="there", at_goal=True)
    robot.run(10.0)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED]


@pytest.mark.parametrize("alone", [False, True])
def test_one_that_is_driven_by_hand_follows_no_grants_and_takes_up_its_goal_afterwards(alone: bool) -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    if alone:
        robot.grant(free=True)
    else:
        robot.grant(*LINE, goal_id="there")
    robot.run(1.5)
    robot.by_hand(request="drive", enable=False)
    robot.run(0.3)
    report = robot.report
    assert (report.aside, report.way, report.free, report.goal_id) == ("by_hand", [], False, "there")
    y = robot.pose.y
    for _ in range(40):
        robot.by_hand(-0.2, 0.4)
        robot.run(0.05)
    assert abs(robot.pose.y - y) > 0.1 and not robot.report.stray
    assert (robot.report.x, robot.report.y) == pytest.approx((robot.pose.x, robot.pose.y), abs=0.1)
    assert robot.report.revision == report.revision
    robot.grant(*LINE, goal_id="there")
    robot.by_hand(0.0, 0.4)
    robot.run(0.3)
    assert robot.report.way == [], "grants that were on their way are given back"
    robot.by_hand(request="give back", enable=False)
    robot.run(0.3)
    assert (robot.report.aside, robot.results) == ("", [])
    robot.grant_from_here(3, goal_id="there", at_goal=True)
    robot.run(15.0)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED]


def test_one_that_docks_drives_on_its_approach_once_that_is_granted_and_stays_out_of_the_plan() -> None:
    spot = {"detection": "map", "charges": False}
    robot = GrantedRobot(docking_server={"dock_types": {"spot": spot}, "dock_prestaging_tolerance": 0.3})
    ended: list[object] = []
    for action in (DOCK_ROBOT, UNDOCK_ROBOT):
        robot.graph.tap(action.result.name, lambda _, message: ended.append(message.status.status))  # type: ignore[union-attr]
    robot.grant((0, 0))
    robot.run(0.5)
    place = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(1.7, 1.0)))
    seen = PoseStamped(Header(frame_id="base_link"), Pose.of(Pose2D(0.5, 0.0)))  # that somebody looks for it suffices
    goal = DockRobotGoal(use_dock_id=False, dock_pose=place, dock_type="spot")
    robot.graph.inject(DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id="d"), goal=goal))
    robot.run(3.0)
    way = [MapPoint(pytest.approx(1.0), pytest.approx(1.0)), MapPoint(pytest.approx(1.7), pytest.approx(1.0))]
    assert (robot.report.aside, robot.report.approach) == ("held", way)
    assert robot.pose.x == pytest.approx(1.0, abs=0.01)
    robot.grant(approach=[MapPoint(9.0, 9.0), MapPoint(9.0, 8.0)])
    robot.run(1.0)
    assert robot.pose.x == pytest.approx(1.0, abs=0.01), "that is an earlier one"
    for _ in range(100):
        if robot.report.approach[1:]:
            robot.grant(approach=robot.report.approach)
        robot.graph.inject("detected_dock_pose", seen)
        robot.run(0.1)
    assert ended == [Status.SUCCEEDED] and robot.pose.x == pytest.approx(1.7, abs=0.03)
    assert (robot.report.aside, robot.report.approach) == ("held", way[1:])
    robot.graph.inject(UNDOCK_ROBOT.goal.name, UndockRobotActionGoal(goal_id=GoalID(id="u")))
    robot.run(1.0)
    assert len(robot.report.approach) == 2 and robot.pose.x == pytest.approx(1.7, abs=0.03)
    for _ in range(20):
        robot.grant(approach=robot.report.approach)
        robot.run(0.5)
    assert ended == [Status.SUCCEEDED] * 2 and robot.pose.x == pytest.approx(1.0, abs=0.06)
    assert (robot.report.aside, robot.report.approach) == ("", [])


def test_one_that_docks_gives_up_if_its_approach_is_never_granted() -> None:
    robot = GrantedRobot(docking_server={"dock_types": {"spot": {"detection": "map", "charges": False}}})
    texts: list[str] = []
    robot.graph.tap(DOCK_ROBOT.result.name, lambda _, message: texts.append(message.status.text))  # type: ignore[union-attr]
    place = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(1.7, 1.0)))
    goal = DockRobotGoal(use_dock_id=False, dock_pose=place, dock_type="spot")
    robot.graph.inject(DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id="d"), goal=goal))
    for _ in range(33):
        robot.grant(waits_for="tb2")
        robot.run(2.0)
    assert texts == ["the way is not free: tb2 goes first"]
    assert robot.pose.x == pytest.approx(1.0, abs=0.01) and not robot.report.approach


def test_grants_of_other_robots_and_of_earlier_epochs_are_ignored() -> None:
    robot = GrantedRobot()
    robot.send_goal(3, 0)
    robot.grant(LINE[0], epoch=2, goal_id="there")
    robot.run(0.5)
    robot.grant(*LINE, epoch=1, goal_id="there")
    robot.run(0.5)
    assert (robot.report.epoch, len(robot.report.way)) == (2, 1)


@pytest.mark.parametrize("other", [{"follow_path": {}}, {"traffic": {"margin": 3}}, {"traffic": {"reaction": -1.0}}])
def test_parameters_that_do_not_fit_are_refused(other: dict[str, dict[str, float]]) -> None:
    with pytest.raises(InvalidParameter):
        build_clone(
            Graph(), build_layers(walled_map(4, 4, [])), model="turtlebot2", initial_pose=(1.0, 1.0, 0.0),
            parameters={"traffic": {}} | other,
        )  # fmt: skip


def test_a_robot_that_makes_a_map_takes_no_part() -> None:
    with pytest.raises(InvalidParameter, match="does not make one"):
        build_clone(Graph(), None, model="turtlebot2", initial_pose=(0.0, 0.0, 0.0), parameters={"traffic": {}})

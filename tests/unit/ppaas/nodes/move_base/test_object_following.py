"""Goals of Nav2's newer actions go on in another container: paths, routes and objects that are followed."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_motions import (
    FollowObjectActionGoal,
    FollowObjectGoal,
    FollowPathActionGoal,
    FollowPathGoal,
)
from ppaas.messages.nav2_servers import ComputeAndTrackRouteActionGoal, ComputeAndTrackRouteGoal
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.nav2_actions import COMPUTE_AND_TRACK_ROUTE, FOLLOW_OBJECT, FOLLOW_PATH
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Lane, Zone, ZoneSet
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

START, MIDDLE, END = Pose2D(1.0, 1.0), Pose2D(3.0, 1.0), Pose2D(5.0, 1.0)
LANES = ZoneSet([Zone(LineString([[1.0, 1.0], [3.0, 1.0], [3.0, 3.0]]), Lane(name="bend"))])


def stamped(pose: Pose2D) -> PoseStamped:
    return PoseStamped(Header(frame_id="map"), Pose.of(pose))


class Loop:
    """Clone that records the results of the actions, and may go on in another one."""

    def __init__(self, start: Pose2D = START) -> None:
        self.driving = ClosedLoop(World(walled_map(6, 4, []), start), masks={"zones": LANES})  # type: ignore[dict-item]
        self.results: list[tuple[str, int]] = []
        for action in (FOLLOW_PATH, COMPUTE_AND_TRACK_ROUTE, FOLLOW_OBJECT):
            self.driving.graph.tap(action.result.name, self._on_result)
        self.run(0.3)

    def _on_result(self, topic: str, message: object) -> None:
        self.results.append((topic.removesuffix("/result"), message.status.status))  # type: ignore[attr-defined]

    def send(self, topic: str, message: Message) -> None:
        self.driving.graph.inject(topic, message)

    def run(self, seconds: float) -> None:
        end = self.driving.clock() + seconds
        while self.driving.clock() < end:
            self.driving.step()

    def moved_on(self) -> "Loop":
        """Return a loop whose clone goes on from the checkpoint of this one."""
        state = self.driving.graph.nodes["move_base"].checkpoint()
        assert state is not None
        other = Loop(self.driving.world.pose)
        other.driving.graph.nodes["move_base"].restore(state)
        return other


def follow_path() -> FollowPathActionGoal:
    path = Path(Header(frame_id="map"), [stamped(START), stamped(MIDDLE), stamped(END)])
    return FollowPathActionGoal(goal=FollowPathGoal(path), goal_id=GoalID(id="p"))


def test_a_path_is_followed_on_from_where_the_robot_is() -> None:
    loop = Loop()
    loop.send(FOLLOW_PATH.goal.name, follow_path())
    loop.run(4.0)
    assert 1.5 < loop.driving.world.pose.x < 4.0
    other = loop.moved_on()
    other.run(25.0)
    assert other.results == [("controller_server/follow_path", Status.SUCCEEDED)]
    assert other.driving.world.pose.distance_to(END) < 0.25


def test_a_path_replaces_a_goal_and_a_goal_replaces_a_path() -> None:
    loop = Loop()
    loop.driving.send_goal(Pose2D(1.0, 3.0))
    loop.run(0.5)
    loop.send(FOLLOW_PATH.goal.name, follow_path())
    loop.run(0.5)
    assert loop.driving.last_status() == Status.PREEMPTED
    loop.driving.send_goal(Pose2D(1.0, 3.0))
    loop.run(0.5)
    assert loop.results == [("controller_server/follow_path", Status.PREEMPTED)]
    assert len(loop.driving.results) == 1, "its result is that of its action alone"


def test_a_path_is_not_moved_by_updates_of_goals() -> None:
    loop = Loop()
    loop.send(FOLLOW_PATH.goal.name, follow_path())
    loop.run(1.0)
    loop.send("goal_update", stamped(Pose2D(1.0, 3.0)))
    loop.run(20.0)
    assert loop.results == [("controller_server/follow_path", Status.SUCCEEDED)]
    assert loop.driving.world.pose.distance_to(END) < 0.25


def test_a_route_is_watched_on() -> None:
    loop = Loop()
    goal = ComputeAndTrackRouteGoal(1, stamped(START), 3, stamped(END))
    loop.send(COMPUTE_AND_TRACK_ROUTE.goal.name, ComputeAndTrackRouteActionGoal(goal=goal, goal_id=GoalID(id="r")))
    loop.driving.send_goal(Pose2D(3.0, 3.0))
    loop.run(3.0)
    assert loop.results == []
    other = loop.moved_on()
    other.run(25.0)
    assert other.results == [("compute_and_track_route", Status.SUCCEEDED)]


@pytest.mark.parametrize("seen", [True, False])
def test_an_object_is_followed_on(seen: bool) -> None:
    def show(loop: Loop, seconds: float) -> None:
        for _ in range(round(4 * seconds)):
            loop.send("dynamic_pose", stamped(END))
            loop.run(0.25)

    loop = Loop()
    goal = FollowObjectGoal("dynamic_pose", "", Duration.of(12.0))
    loop.send(FOLLOW_OBJECT.goal.name, FollowObjectActionGoal(goal=goal, goal_id=GoalID(id="o")))
    show(loop, 3.0)
    assert 1.2 < loop.driving.world.pose.x < 4.0
    other = loop.moved_on()
    if seen:
        show(other, 7.0)
        assert other.driving.world.pose.x == pytest.approx(4.0, abs=0.35)
    other.run(4.0 if seen else 11.5)
    assert other.results == [("follow_object", Status.SUCCEEDED)], "its time has passed"
    assert other.driving.command.linear.x == 0.0

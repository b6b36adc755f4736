"""Waypoint following in a closed loop: sends lists of waypoints to a clone, and records its messages."""

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_msgs import FollowWaypointsActionGoal, FollowWaypointsActionResult, FollowWaypointsGoal
from tests.support.world.closed_loop import ClosedLoop


def stamped(pose: Pose2D, frame: str = "map") -> PoseStamped:
    return PoseStamped(Header(frame_id=frame), Pose.of(pose))


def waypoints(poses, goal_id: str = "tour", *, stamp: float = 0.0, **numbers) -> FollowWaypointsActionGoal:
    """Return the action goal of a list of waypoints, which may be stamped already."""
    listed = [pose if isinstance(pose, PoseStamped) else stamped(pose) for pose in poses]
    return FollowWaypointsActionGoal(FollowWaypointsGoal(listed, **numbers), GoalID(Time.of(stamp), goal_id))


class Tour:
    """A closed loop, with the messages of its waypoint follower and the goals of its Move Base."""

    def __init__(self, driving: ClosedLoop) -> None:
        self.driving = driving
        self.results: list[FollowWaypointsActionResult] = []
        self.texts: list[str] = []
        self.visited: list[int] = []
        self.goals: list[str] = []
        for name, hear in (
            ("result", self.results.append),
            ("status", self._on_status),
            ("feedback", lambda message: self._on_index(message.feedback.current_waypoint)),
        ):
            driving.graph.tap(f"follow_waypoints/{name}", lambda _, message, hear=hear: hear(message))
        driving.graph.tap("move_base/goal", lambda _, message: self.goals.append(message.goal_id.id))

    def _on_status(self, message: GoalStatusArray) -> None:
        text = message.status_list[-1].text if message.status_list else ""
        if self.texts[-1:] != [text]:
            self.texts.append(text)

    def _on_index(self, index: int) -> None:
        if self.visited[-1:] != [index]:
            self.visited.append(index)

    def send(self, *args, **options) -> None:
        self.driving.graph.inject("follow_waypoints/goal", waypoints(*args, **options))

    def run(self, seconds: float) -> None:
        """Simulate until a list ends, at most for a time [s]."""
        had = len(self.results)
        end = self.driving.clock() + seconds
        while len(self.results) == had and self.driving.clock() < end:
            self.driving.step()

    def until(self, text: str, seconds: float = 60.0) -> None:
        """Simulate until the status text of the list is ``text``."""
        end = self.driving.clock() + seconds
        while self.texts[-1:] != [text]:
            assert self.driving.clock() < end, self.texts
            self.driving.step()

    @property
    def outcome(self):
        """Status, error code and text of the last list that ended."""
        last = self.results[-1]
        return last.status.status, last.result.error_code, last.status.text

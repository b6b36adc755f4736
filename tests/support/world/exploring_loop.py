"""Exploration in a closed loop: sends goals of ``explore`` to a clone that maps, and records its messages."""

from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.explore_msgs import ExploreActionFeedback, ExploreActionGoal, ExploreActionResult, ExploreGoal
from tests.support.world.closed_loop import ClosedLoop


class ExploringLoop:
    """A closed loop, with the messages of its node ``explore`` and the goals of its Move Base."""

    def __init__(self, driving: ClosedLoop) -> None:
        self.driving = driving
        self.results: list[ExploreActionResult] = []
        self.feedback: list[ExploreActionFeedback] = []
        self.goals: list[str] = []
        graph = driving.graph
        graph.tap("explore/result", lambda _, message: self.results.append(message))
        graph.tap("explore/feedback", lambda _, message: self.feedback.append(message))
        graph.tap("move_base/goal", lambda _, message: self.goals.append(message.goal_id.id))

    @property
    def texts(self) -> list[str]:
        """Return the texts of the feedback, without repetitions."""
        texts = [message.feedback.text for message in self.feedback]
        return [text for text, before in zip(texts, ["", *texts], strict=False) if text != before]

    def send(self, goal_id: str = "look", *, return_to_start: bool = False) -> None:
        self.driving.graph.inject("explore/goal", ExploreActionGoal(ExploreGoal(return_to_start), GoalID(id=goal_id)))

    def run(self, seconds: float) -> None:
        """Simulate until a goal of ``explore`` ends, at most for a time [s]."""
        had, end = len(self.results), self.driving.clock() + seconds
        while len(self.results) == had and self.driving.clock() < end:
            self.driving.step()

    @property
    def outcome(self) -> tuple[int, str]:
        """Status and text of the last goal that ended."""
        last = self.results[-1]
        return last.status.status, last.status.text

"""Node ``tf2_web_republisher``: transforms are published when they change, while a topic has subscribers."""

import pytest

from ppaas.errors import InvalidInput, NotFound, PPaaSError, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.std_msgs import Duration, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.tf2_web_republisher import RepublishTFsRequest, TFSubscriptionActionGoal, TFSubscriptionGoal
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.republisher import MAX_PATIENCE, MAX_STREAMS, TfRepublisherNode
from ppaas.nodes.tf.stream import MAX_SOURCES
from ppaas.nodes.topics import TF_REPUBLISHER_CANCEL as CANCEL
from ppaas.nodes.topics import TF_REPUBLISHER_FEEDBACK as FEEDBACK
from ppaas.nodes.topics import TF_REPUBLISHER_GOAL as GOAL
from ppaas.nodes.topics import TF_REPUBLISHER_RESULT as RESULT
from ppaas.nodes.topics import TF_REPUBLISHER_STATUS as STATUS
from ppaas.transforms.planar import transform_message

PERIOD = 0.1


class Home:
    """A graph with a republisher, and a clock that the test controls."""

    def __init__(self) -> None:
        self.now = 0.0
        self.graph = Graph(clock=lambda: self.now, stamp_clock=lambda: 1000.0 + self.now)
        self.node = self.graph.add(TfRepublisherNode)
        self.told: list[tuple[str, object]] = []

    def moves(self, x: float, theta: float = 0.0, child: str = "base_link") -> None:
        self.graph.inject("tf", TFMessage([transform_message("map", child, Pose2D(x, 0.0, theta), Time(1))]))

    def passes(self, seconds: float) -> None:
        end = self.now + seconds
        while (due := self.now + self.graph.run_due()) <= end:
            self.now = due
        self.now = end

    def hears(self, topic: str):
        return self.graph.tap(topic, lambda name, message: self.told.append((name, message)))

    def asks(self, **fields: object) -> str:
        wanted = {"source_frames": ["base_link"], "target_frame": "/map", "rate": 1 / PERIOD} | fields
        answers: list[object] = []
        self.graph.call("republish_tfs", RepublishTFsRequest(**wanted), answers.append)
        if isinstance(answers[0], PPaaSError):
            raise answers[0]
        assert answers[0].topic_name.startswith("/tf2_web_republisher/")
        return answers[0].topic_name.removeprefix("/")

    def sends(self, goal_id: str = "g", **fields: object) -> None:
        wanted = {"source_frames": ["base_link"], "target_frame": "map", "rate": 1 / PERIOD} | fields
        self.graph.inject(GOAL.name, TFSubscriptionActionGoal(TFSubscriptionGoal(**wanted), GoalID(Time(5), goal_id)))

    def xs(self) -> list[float]:
        """Return the x of the frames published so far, and forget them."""
        arrays = [getattr(message, "feedback", message) for _, message in self.told]
        self.told.clear()
        return [transform.transform.translation.x for array in arrays for transform in array.transforms]


@pytest.fixture
def home() -> Home:
    return Home()


# -- topics ------------------------------------------------------------------------------------------------------------


def test_a_frame_is_told_at_first_and_then_when_it_has_moved_or_turned_by_more_than_its_threshold(home):
    home.moves(1.0)
    home.hears(home.asks(trans_thres=0.5, angular_thres=1.0))
    home.passes(3 * PERIOD)
    assert home.xs() == [1.0]
    home.moves(1.4)
    home.passes(3 * PERIOD)
    assert home.xs() == []
    home.moves(1.6)
    home.passes(3 * PERIOD)
    assert home.xs() == [1.6]
    home.moves(1.6, theta=1.1)
    home.passes(3 * PERIOD)
    assert home.xs() == [1.6]


def test_the_array_says_which_frame_lies_where_in_which_and_when(home):
    home.moves(1.0)
    home.moves(5.0, child="/laser")
    home.hears(home.asks(source_frames=["/base_link", "laser", "nothing"]))
    home.passes(PERIOD)
    [(_, array)] = home.told
    told = {each.child_frame_id: each for each in array.transforms}
    assert set(told) == {"base_link", "laser"}, "without slashes, and without what is not known"
    assert {each.header.frame_id for each in told.values()} == {"map"}
    assert told["laser"].transform.translation.x == 5.0
    assert told["laser"].header.stamp == Time.of(1000.0 + PERIOD)


def test_it_is_told_at_most_at_the_rate_whatever_happens_between(home):
    home.hears(home.asks(rate=2.0))
    for step in range(80):
        home.moves(float(step))
        home.passes(0.0625)
    assert len(home.told) == 10


def test_without_thresholds_it_is_told_each_time(home):
    home.moves(1.0)
    home.hears(home.asks(trans_thres=0.0, angular_thres=2.0))
    home.passes(5.5 * PERIOD)
    assert home.xs() == [1.0] * 5


def test_a_frame_that_comes_later_is_told_then(home):
    home.hears(home.asks())
    home.passes(3 * PERIOD)
    home.graph.inject("tf_static", TFMessage([transform_message("map", "base_link", Pose2D(3.0, 0.0), Time())]))
    home.passes(1.5 * PERIOD)
    assert home.xs() == [3.0]


def test_who_comes_back_in_time_is_told_all_again_and_who_does_not_finds_the_topic_gone(home):
    home.moves(1.0)
    topic = home.asks(trans_thres=1.0, angular_thres=1.0, timeout=Duration(2))
    unhear = home.hears(topic)
    home.passes(1.0)
    unhear()
    home.passes(1.5)
    assert home.xs() == [1.0]
    unhear = home.hears(topic)
    home.passes(1.0)
    assert home.xs() == [1.0]
    unhear()
    home.passes(2.5)
    with pytest.raises(NotFound):
        home.hears(topic)
    assert home.graph.checkpoints() == []


def test_nothing_is_left_to_do_once_nobody_wants_anything(home):
    home.asks()
    home.sends()
    home.passes(MAX_PATIENCE + 20.0)
    assert home.graph.run_due() == float("inf")
    assert set(home.graph.topics) == {
        "tf",
        "tf_static",
        *(topic.name for topic in (GOAL, CANCEL, STATUS, FEEDBACK, RESULT)),
    }


def test_each_who_asks_has_a_topic_of_its_own_and_there_are_so_many(home):
    topics = {home.asks() for _ in range(MAX_STREAMS)}
    assert len(topics) == MAX_STREAMS
    with pytest.raises(QuotaExceeded, match=f"at most {MAX_STREAMS}"):
        home.asks()


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"rate": 0.0}, "rate"), ({"rate": -1.0}, "rate"), ({"rate": float("nan")}, "rate"),
        ({"trans_thres": -1.0}, "trans_thres"), ({"angular_thres": float("inf")}, "angular_thres"),
        ({"target_frame": ""}, "name"), ({"target_frame": "/"}, "name"), ({"source_frames": ["x" * 300]}, "name"),
        ({"source_frames": ["a"] * (MAX_SOURCES + 1)}, "source_frames"),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_refused(home, fields, text):
    with pytest.raises(InvalidInput, match=text):
        home.asks(**fields)
    with pytest.raises(InvalidInput, match=text):
        home.sends(**fields)
    assert home.graph.checkpoints() == []
    assert home.graph.run_due() == float("inf")


def test_an_endless_rate_is_held_to_the_highest(home):
    home.moves(1.0)
    home.hears(home.asks(rate=1e9))
    home.passes(1.01)
    assert len(home.told) == 50


# -- goals -------------------------------------------------------------------------------------------------------------


def statuses(home: Home) -> dict[str, int]:
    latched = home.graph.latched(STATUS.name)
    return {status.goal_id.id: status.status for status in latched.status_list}


def test_a_goal_is_told_by_feedback_until_it_is_cancelled_and_then_ends_once(home):
    assert statuses(home) == {}, "said from the start, so that a client knows the server"
    home.moves(1.0)
    home.hears(FEEDBACK.name)
    home.sends("g")
    home.sends("g")
    home.passes(2.5 * PERIOD)
    assert [message.status.goal_id.id for _, message in home.told] == ["g", "g"], "and what comes twice is one goal"
    assert home.xs() == [1.0, 1.0]
    assert statuses(home) == {"g": Status.ACTIVE}
    home.hears(RESULT.name)
    home.graph.inject(CANCEL.name, GoalID(id="g"))
    home.graph.inject(CANCEL.name, GoalID(id="g"))
    home.passes(1.0)
    [(topic, result)] = home.told
    assert (topic, result.status.goal_id.id, result.status.status) == (RESULT.name, "g", Status.PREEMPTED)
    assert statuses(home) == {"g": Status.PREEMPTED}


@pytest.mark.parametrize(
    ("cancel", "left"),
    [(GoalID(), set()), (GoalID(Time(5)), set()), (GoalID(id="a"), {"b"}), (GoalID(Time(4)), {"a", "b"})],
)
def test_a_cancel_means_one_goal_or_those_up_to_a_stamp_or_all(home, cancel, left):
    home.sends("a")
    home.sends("b")
    home.graph.inject(CANCEL.name, cancel)
    assert {goal for goal, status in statuses(home).items() if status == Status.ACTIVE} == left


def test_a_goal_without_an_id_gets_one(home):
    home.sends("")
    home.sends("")
    assert len(statuses(home)) == 2
    assert "" not in statuses(home)


def test_the_oldest_goal_makes_room_for_a_new_one(home):
    home.hears(RESULT.name)
    for number in range(MAX_STREAMS + 1):
        home.sends(f"g{number}")
    home.asks()
    ended = [(message.status.goal_id.id, message.status.status) for _, message in home.told]
    assert ended == [("g0", Status.ABORTED), ("g1", Status.ABORTED)]


def test_a_goal_whose_feedback_nobody_hears_any_more_ends(home):
    unhear = home.hears(FEEDBACK.name)
    home.sends("g")
    home.passes(2 * MAX_PATIENCE)
    assert statuses(home) == {"g": Status.ACTIVE}
    unhear()
    home.passes(MAX_PATIENCE + 1.0)
    assert statuses(home) == {"g": Status.ABORTED}


# -- going on elsewhere ------------------------------------------------------------------------------------------------


def test_topics_and_goals_go_on_elsewhere_under_their_names(home):
    topic = home.asks()
    home.sends("g", rate=5.0)
    elsewhere = Home()
    elsewhere.graph.restore(home.graph.checkpoints())
    assert statuses(elsewhere) == {"g": Status.ACTIVE}
    assert elsewhere.graph.checkpoints() == home.graph.checkpoints()
    assert elsewhere.asks() != topic
    elsewhere.hears(topic)
    elsewhere.hears(FEEDBACK.name)
    elsewhere.moves(2.0)
    elsewhere.passes(0.25)
    assert sorted(name for name, _ in elsewhere.told) == sorted([topic, topic, FEEDBACK.name])


def test_a_request_of_another_type_is_refused(home):
    answers: list[object] = []
    home.graph.call("republish_tfs", GoalID(), answers.append)
    assert isinstance(answers[0], InvalidInput)

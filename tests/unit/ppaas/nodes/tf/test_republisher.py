"""Node ``tf2_web_republisher``: transforms are published when they change, while a topic has subscribers."""

import pytest

from ppaas.errors import InvalidInput, NotFound, PPaaSError, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.tf2_web_republisher import RepublishTFsRequest, TFSubscriptionActionGoal, TFSubscriptionGoal
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.republisher import MAX_PATIENCE, MAX_SOURCES, MAX_STREAMS, TfRepublisherNode
from ppaas.nodes.topics import TF_REPUBLISHER_CANCEL as CANCEL
from ppaas.nodes.topics import TF_REPUBLISHER_FEEDBACK as FEEDBACK
from ppaas.nodes.topics import TF_REPUBLISHER_GOAL as GOAL
from ppaas.nodes.topics import TF_REPUBLISHER_RESULT as RESULT
from ppaas.nodes.topics import TF_REPUBLISHER_STATUS as STATUS
from ppaas.transforms.planar import transform_message

PERIOD = 0.1


class RepublisherUnderTest:
    """A graph with a republisher, and a clock that the test controls."""

    def __init__(self) -> None:
        self.now = 0.0
        self.graph = Graph(clock=lambda: self.now, stamp_clock=lambda: 1000.0 + self.now)
        self.node = self.graph.add(TfRepublisherNode)
        self.received: list[tuple[str, object]] = []

    def move(self, x: float, theta: float = 0.0, child: str = "base_link") -> None:
        self.graph.inject("tf", TFMessage([transform_message("map", child, Pose2D(x, 0.0, theta), Time(1))]))

    def wait(self, seconds: float) -> None:
        end = self.now + seconds
        while (due := self.now + self.graph.run_due()) <= end:
            self.now = due
        self.now = end

    def subscribe(self, topic: str):
        return self.graph.tap(topic, lambda name, message: self.received.append((name, message)))

    def request(self, **fields: object) -> str:
        wanted = {"source_frames": ["base_link"], "target_frame": "/map", "rate": 1 / PERIOD} | fields
        answers: list[object] = []
        self.graph.call("republish_tfs", RepublishTFsRequest(**wanted), answers.append)
        if isinstance(answers[0], PPaaSError):
            raise answers[0]
        assert answers[0].topic_name.startswith("/tf2_web_republisher/")
        return answers[0].topic_name.removeprefix("/")

    def send(self, goal_id: str = "g", **fields: object) -> None:
        wanted = {"source_frames": ["base_link"], "target_frame": "map", "rate": 1 / PERIOD} | fields
        self.graph.inject(GOAL.name, TFSubscriptionActionGoal(TFSubscriptionGoal(**wanted), GoalID(Time(5), goal_id)))

    def xs(self) -> list[float]:
        """Return the x of the frames published so far, and forget them."""
        arrays = [getattr(message, "feedback", message) for _, message in self.received]
        self.received.clear()
        return [transform.transform.translation.x for array in arrays for transform in array.transforms]


@pytest.fixture
def republisher() -> RepublisherUnderTest:
    return RepublisherUnderTest()


# -- topics ------------------------------------------------------------------------------------------------------------


def test_frame_is_published_when_it_moves_beyond_a_threshold(republisher):
    republisher.move(1.0)
    republisher.subscribe(republisher.request(trans_thres=0.5, angular_thres=1.0))
    republisher.wait(3 * PERIOD)
    assert republisher.xs() == [1.0]
    republisher.move(1.4)
    republisher.wait(3 * PERIOD)
    assert republisher.xs() == []
    republisher.move(1.6)
    republisher.wait(3 * PERIOD)
    assert republisher.xs() == [1.6]
    republisher.move(1.6, theta=1.1)
    republisher.wait(3 * PERIOD)
    assert republisher.xs() == [1.6]


def test_transforms_have_frames_poses_and_stamps(republisher):
    republisher.move(1.0)
    republisher.move(5.0, child="/laser")
    republisher.subscribe(republisher.request(source_frames=["/base_link", "laser", "nothing"]))
    republisher.wait(PERIOD)
    [(_, array)] = republisher.received
    transforms = {each.child_frame_id: each for each in array.transforms}
    assert set(transforms) == {"base_link", "laser"}, "without slashes and unknown frames"
    assert {each.header.frame_id for each in transforms.values()} == {"map"}
    assert transforms["laser"].transform.translation.x == 5.0
    assert transforms["laser"].header.stamp == Time.of(1000.0 + PERIOD)


def test_publication_rate_is_limited(republisher):
    republisher.subscribe(republisher.request(rate=2.0))
    for step in range(80):
        republisher.move(float(step))
        republisher.wait(0.0625)
    assert len(republisher.received) == 10


def test_zero_threshold_publishes_every_time(republisher):
    republisher.move(1.0)
    republisher.subscribe(republisher.request(trans_thres=0.0, angular_thres=2.0))
    republisher.wait(5.5 * PERIOD)
    assert republisher.xs() == [1.0] * 5


def test_frame_is_published_once_it_is_known(republisher):
    republisher.subscribe(republisher.request())
    republisher.wait(3 * PERIOD)
    republisher.graph.inject("tf_static", TFMessage([transform_message("map", "base_link", Pose2D(3.0, 0.0), Time())]))
    republisher.wait(1.5 * PERIOD)
    assert republisher.xs() == [3.0]


def test_topic_outlives_its_subscriber_for_the_timeout(republisher):
    republisher.move(1.0)
    topic = republisher.request(trans_thres=1.0, angular_thres=1.0, timeout=Duration(2))
    unsubscribe = republisher.subscribe(topic)
    republisher.wait(1.0)
    unsubscribe()
    republisher.wait(1.5)
    assert republisher.xs() == [1.0]
    unsubscribe = republisher.subscribe(topic)
    republisher.wait(1.0)
    assert republisher.xs() == [1.0]
    unsubscribe()
    republisher.wait(2.5)
    with pytest.raises(NotFound):
        republisher.subscribe(topic)
    assert republisher.graph.checkpoints() == []


def test_unused_topics_and_goals_expire(republisher):
    republisher.request()
    republisher.send()
    republisher.wait(MAX_PATIENCE + 20.0)
    assert republisher.graph.run_due() == float("inf")
    assert set(republisher.graph.topics) == {
        "tf",
        "tf_static",
        *(topic.name for topic in (GOAL, CANCEL, STATUS, FEEDBACK, RESULT)),
    }


def test_each_request_has_its_own_topic_up_to_a_limit(republisher):
    topics = {republisher.request() for _ in range(MAX_STREAMS)}
    assert len(topics) == MAX_STREAMS
    with pytest.raises(QuotaExceeded, match=f"at most {MAX_STREAMS}"):
        republisher.request()


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"rate": 0.0}, "rate"), ({"rate": -1.0}, "rate"), ({"rate": float("nan")}, "rate"),
        ({"trans_thres": -1.0}, "trans_thres"), ({"angular_thres": float("inf")}, "angular_thres"),
        ({"target_frame": ""}, "name"), ({"target_frame": "/"}, "name"), ({"source_frames": ["x" * 300]}, "name"),
        ({"source_frames": ["a"] * (MAX_SOURCES + 1)}, "source_frames"),
    ],
)  # fmt: skip
def test_invalid_request_is_refused(republisher, fields, text):
    with pytest.raises(InvalidInput, match=text):
        republisher.request(**fields)
    with pytest.raises(InvalidInput, match=text):
        republisher.send(**fields)
    assert republisher.graph.checkpoints() == []
    assert republisher.graph.run_due() == float("inf")


def test_too_high_rate_is_limited(republisher):
    republisher.move(1.0)
    republisher.subscribe(republisher.request(rate=1e9))
    republisher.wait(1.01)
    assert len(republisher.received) == 50


# -- goals -------------------------------------------------------------------------------------------------------------


def statuses(republisher: RepublisherUnderTest) -> dict[str, int]:
    latched = republisher.graph.latched(STATUS.name)
    return {status.goal_id.id: status.status for status in latched.status_list}


def test_goal_gives_feedback_until_cancelled_and_ends_once(republisher):
    assert statuses(republisher) == {}, "published from the start, for clients"
    republisher.move(1.0)
    republisher.subscribe(FEEDBACK.name)
    republisher.send("g")
    republisher.send("g")
    republisher.wait(2.5 * PERIOD)
    assert [message.status.goal_id.id for _, message in republisher.received] == ["g", "g"], (
        "a repeated goal counts once"
    )
    assert republisher.xs() == [1.0, 1.0]
    assert statuses(republisher) == {"g": Status.ACTIVE}
    republisher.subscribe(RESULT.name)
    republisher.graph.inject(CANCEL.name, GoalID(id="g"))
    republisher.graph.inject(CANCEL.name, GoalID(id="g"))
    republisher.wait(1.0)
    [(topic, result)] = republisher.received
    assert (topic, result.status.goal_id.id, result.status.status) == (RESULT.name, "g", Status.PREEMPTED)
    assert statuses(republisher) == {"g": Status.PREEMPTED}


@pytest.mark.parametrize(
    ("cancel", "left"),
    [(GoalID(), set()), (GoalID(Time(5)), set()), (GoalID(id="a"), {"b"}), (GoalID(Time(4)), {"a", "b"})],
)
def test_cancel_applies_to_one_goal_up_to_a_stamp_or_all(republisher, cancel, left):
    republisher.send("a")
    republisher.send("b")
    republisher.graph.inject(CANCEL.name, cancel)
    assert {goal for goal, status in statuses(republisher).items() if status == Status.ACTIVE} == left


def test_a_goal_without_an_id_gets_one(republisher):
    republisher.send("")
    republisher.send("")
    assert len(statuses(republisher)) == 2
    assert "" not in statuses(republisher)


def test_oldest_goal_is_aborted_for_a_new_one(republisher):
    republisher.subscribe(RESULT.name)
    for number in range(MAX_STREAMS + 1):
        republisher.send(f"g{number}")
    republisher.request()
    ended = [(message.status.goal_id.id, message.status.status) for _, message in republisher.received]
    assert ended == [("g0", Status.ABORTED), ("g1", Status.ABORTED)]


def test_goal_without_feedback_subscribers_is_aborted(republisher):
    unsubscribe = republisher.subscribe(FEEDBACK.name)
    republisher.send("g")
    republisher.wait(2 * MAX_PATIENCE)
    assert statuses(republisher) == {"g": Status.ACTIVE}
    unsubscribe()
    republisher.wait(MAX_PATIENCE + 1.0)
    assert statuses(republisher) == {"g": Status.ABORTED}


# -- checkpoints -------------------------------------------------------------------------------------------------------


def test_topics_and_goals_are_restored_from_a_checkpoint(republisher):
    topic = republisher.request()
    republisher.send("g", rate=5.0)
    elsewhere = RepublisherUnderTest()
    elsewhere.graph.restore(republisher.graph.checkpoints())
    assert statuses(elsewhere) == {"g": Status.ACTIVE}
    assert elsewhere.graph.checkpoints() == republisher.graph.checkpoints()
    assert elsewhere.request() != topic
    elsewhere.subscribe(topic)
    elsewhere.subscribe(FEEDBACK.name)
    elsewhere.move(2.0)
    elsewhere.wait(0.25)
    assert sorted(name for name, _ in elsewhere.received) == sorted([topic, topic, FEEDBACK.name])


def test_a_request_of_another_type_is_refused(republisher):
    answers: list[object] = []
    republisher.graph.call("republish_tfs", GoalID(), answers.append)
    assert isinstance(answers[0], InvalidInput)

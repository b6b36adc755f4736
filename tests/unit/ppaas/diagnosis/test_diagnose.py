"""Diagnosis: findings by how bad they are, and their words."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.diagnosis.diagnose import diagnose
from ppaas.diagnosis.observations.facts import LinkFacts, TopicFacts, observations_from_json, observations_to_json
from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.observations.recorder import HEARD, ObservationRecorder
from ppaas.diagnosis.rules.finding import LEVELS, capital, count, hertz, names, nearest, percent, seconds, size
from ppaas.messages.base.message import Message
from tests.support.world.diagnosed_robot import LINK, healthy, kinds
from tests.support.world.planar_world import walled_map

NUMBERS = st.none() | st.floats() | st.sampled_from([0.0, 1.0, 1e308, -1e308])
FLOATS = st.floats() | st.sampled_from([0.0, 1.0, 1e308])
FRAMES = st.sampled_from(["", "odom", "base_link", "laser", "map", "/laser", "tb1/torso_1"])
STAMPS = st.fixed_dictionaries({"secs": st.integers(-(10**30), 10**30), "nsecs": st.integers(-(10**12), 10**12)})
HEADERS = st.fixed_dictionaries({"stamp": STAMPS, "frame_id": FRAMES})
VECTORS = st.fixed_dictionaries({"x": FLOATS, "y": FLOATS, "z": FLOATS})
TURNS = st.fixed_dictionaries({"x": FLOATS, "y": FLOATS, "z": FLOATS, "w": FLOATS})
COVARIANCES = st.floats().map(lambda variance: [variance] * 36)
POSES = st.fixed_dictionaries({"position": VECTORS, "orientation": TURNS})
TWISTS = st.fixed_dictionaries({"linear": VECTORS, "angular": VECTORS})
UNSURE_POSES = st.fixed_dictionaries({"pose": POSES, "covariance": COVARIANCES})
TRANSFORMS = st.fixed_dictionaries({"translation": VECTORS, "rotation": TURNS})
STAMPED = st.fixed_dictionaries({"header": HEADERS, "child_frame_id": FRAMES, "transform": TRANSFORMS})
TF = st.fixed_dictionaries({"transforms": st.lists(STAMPED, max_size=2)})
SCANS = st.fixed_dictionaries(
    {"header": HEADERS, "ranges": st.lists(NUMBERS, max_size=4), "intensities": st.just([])}
    | dict.fromkeys(("angle_min", "angle_max", "angle_increment", "range_min", "range_max"), FLOATS)
)
ODOMETRY = st.fixed_dictionaries(
    {
        "header": HEADERS,
        "child_frame_id": FRAMES,
        "pose": UNSURE_POSES,
        "twist": st.fixed_dictionaries({"twist": TWISTS}),
    }
)
SENT = (
    st.tuples(st.just("scan"), SCANS)
    | st.tuples(st.just("odom"), ODOMETRY)
    | st.tuples(st.sampled_from(["tf", "tf_static"]), TF)
    | st.tuples(st.just("cmd_vel"), TWISTS)
    | st.tuples(st.just("amcl_pose"), st.fixed_dictionaries({"header": HEADERS, "pose": UNSURE_POSES}))
)
TYPES = {topic.name: topic.type for topic in HEARD}
LAYERS = build_layers(walled_map(2, 2, []))


def message_of(topic: str, fields: object) -> Message:
    """Return a message with any numbers, as one in a program may have."""
    return msgspec.convert(fields, TYPES[topic], strict=False)


@given(st.lists(SENT, max_size=4))
def test_whatever_a_robot_sends_is_judged_without_a_failure(sent: list[tuple[str, object]]) -> None:
    recorder, now = ObservationRecorder(0.0), 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        for topic, fields in sent:
            now += 0.5
            recorder.take(topic, message_of(topic, fields), now, 1.7e9 + now)
        seen = recorder.observations(now, WatchedRobot(layers=lambda: LAYERS, radius=lambda: 0.2))
    seen.topics, seen.link = [TopicFacts(name="scan", silence=0.1, refused=1, refusal="x")], LINK
    again = observations_from_json(observations_to_json(seen))
    assert [finding.kind for finding in diagnose(again)]


def test_worst_findings_come_first_and_notes_last() -> None:
    link = msgspec.structs.replace(LINK, round_trip=0.9, subscribed=())
    levels = [finding.level for finding in diagnose(healthy(link=link))]
    assert levels == sorted(levels, key=LEVELS.index, reverse=True)
    assert set(levels) == {"error", "warn", "ok"}


def test_robot_that_is_not_connected_is_not_judged_further() -> None:
    assert kinds(diagnose(healthy(topics=[], link=LinkFacts()))) == ["robot-not-connected"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (seconds(0.42), "0.4 s"), (seconds(200.0), "3 min"), (seconds(9e3), "2 h"),
        (seconds(3e5), "3 days"), (size(800), "800 bytes"), (size(12e3), "12 kB"),
        (size(1.44e6), "1.4 MB"), (hertz(10.02), "10 Hz"), (hertz(0.4), "0.4 Hz"),
        (percent(0.256), "26 %"), (count(1, "message"), "1 message"), (count(3, "time"), "3 times"),
        (names([]), "none"), (names("abcdefghijklmn"), "a, b, c, d, e, f, g, h, i, j, k, l and 2 more"),
        (capital("it is"), "It is."), (nearest("lasr", ["laser", "odom"]), "laser"),
        (nearest("zzz", ["laser", "odom"]), ""), (nearest("laser", ["r1/laser"]), "r1/laser"),
    ],
)  # fmt: skip
def test_values_are_put_in_words(text: str, expected: str) -> None:
    assert text == expected

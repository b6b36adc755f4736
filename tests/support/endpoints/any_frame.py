"""Hypothesis strategies of rosbridge frames, most of them nearly valid.

They have the operations, names, types and ids of a clone that is there, with anything else in some fields.
"""

import json
import random
from typing import Any

import cbor2
from hypothesis import strategies as st

from tests.support.endpoints.still_place import TOPICS

OPS = (
    "publish", "subscribe", "unsubscribe", "advertise", "unadvertise", "call_service", "advertise_service",
    "unadvertise_service", "service_response", "send_action_goal", "cancel_action_goal", "set_level", "fragment",
    "advertise_action", "unadvertise_action", "action_feedback", "action_result", "auth", "png",
)  # fmt: skip
NAMES = (
    *(topic.name for topic in TOPICS), "/chatter", "chatter", "/lights", "make_plan", "move_base", "/navigate_to_pose",
    "move_base/_action/cancel_goal", "/dock", "/dock/_action/cancel_goal", "/ppaas/heartbeat", "", "a b", "~", "~/x",
    "/" * 9, "ä", "x" * 300,
)  # fmt: skip
TYPES = (
    "std_msgs/String", "std_msgs/msg/String", "geometry_msgs/Twist", "move_base_msgs/MoveBaseAction",
    "nav2_msgs/action/NavigateToPose", "std_srvs/Trigger", "nav_msgs/GetPlan", "String", "",
)  # fmt: skip
IDS = ("1", "2", 1, 2, 2**70, "9" * 30, "²", "", "\u0000")

NUMBERS = st.integers(-1, 2**70) | st.floats(allow_nan=False, allow_infinity=False)
JSON: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["pose", "data", "x"]), inner, max_size=3)
    ),
    max_leaves=4,
)
FIELDS: dict[str, st.SearchStrategy[Any]] = {
    "topic": st.sampled_from(NAMES), "service": st.sampled_from(NAMES), "action": st.sampled_from(NAMES),
    "type": st.sampled_from(TYPES), "action_type": st.sampled_from(TYPES), "id": st.sampled_from(IDS),
    "msg": JSON, "args": JSON, "values": JSON, "result": st.booleans(), "latch": st.booleans(),
    "feedback": st.booleans(), "level": st.sampled_from(["none", "error", "info", "loud"]),
    "compression": st.sampled_from(["none", "png", "cbor", "cbor-raw", "zip", ""]),
    "throttle_rate": st.integers(-1, 50), "queue_length": st.integers(-1, 2000), "timeout": NUMBERS,
    "status": st.integers(-1, 7), "data": st.text(max_size=5), "num": st.integers(-1, 3), "total": st.integers(0, 3),
}  # fmt: skip


# Made once: Hypothesis examines every new strategy.
_OPERATION, _WRONG = st.sampled_from(OPS), st.sets(st.sampled_from(sorted(FIELDS)), max_size=2)
_SEED = st.integers(0, 2**32)


@st.composite
def nearly_right(draw: st.DrawFn) -> str:
    """Return an operation with mostly valid fields."""
    frame = {"op": draw(_OPERATION)}
    wrong = draw(_WRONG)
    # One seed instead of a draw a field: thousands of frames of sixteen fields must cost seconds.
    dice = random.Random(draw(_SEED))
    for name, strategy in FIELDS.items():
        if name in wrong:
            frame[name] = draw(JSON if dice.random() < 0.5 else strategy)
        elif dice.random() < 0.9:
            frame[name] = GOOD[name](dice)
    return json.dumps(frame)


def _one_of(*values: Any) -> Any:
    return lambda dice: dice.choice(values)


GOOD: dict[str, Any] = {
    "topic": _one_of(*NAMES[:10], *["/chatter", "chatter"] * 5),
    "service": _one_of("/lights", "make_plan", "lights", "lights"),
    "action": _one_of("move_base", "/navigate_to_pose", "/dock"),
    "type": _one_of(*TYPES[:7], *["std_msgs/String"] * 5),
    "action_type": _one_of(*TYPES[3:5]), "id": _one_of("1", "2", 3, 4),
    "msg": _one_of({}, {"data": 1}, {"header": {"stamp": {"secs": 1, "nsecs": 2}}}),
    "args": _one_of({}, [], {"target_pose": {}}), "values": _one_of({}, "no", None), "result": _one_of(True, False),
    "latch": _one_of(True, False), "feedback": _one_of(True), "level": _one_of("none", "error", "info"),
    "compression": _one_of(None, "none", "png", "cbor", "cbor-raw"),
    "throttle_rate": _one_of(0, None, 5), "queue_length": _one_of(0, 3), "timeout": _one_of(0.01, -1, 1e300),
    "status": _one_of(4, 5, 6), "data": _one_of('{"op":', "\"publish\"}"), "num": _one_of(0, 1), "total": _one_of(1, 2),
}  # fmt: skip

RUBBISH = st.text(max_size=20) | st.sampled_from(["{", "[]", '{"op":1}', "[" * 5000, "\ud800", '"', "\x00"])
BINARY_RUBBISH = st.binary(max_size=40) | st.sampled_from([b"\xff", b"\xa1", b"\x01\0", b"\x02" + bytes(31)])
_NEARLY_RIGHT = nearly_right()
_IN_CBOR = _NEARLY_RIGHT.map(lambda frame: cbor2.dumps(json.loads(frame)))
FRAME = st.integers(0, 19).flatmap(
    lambda number: {0: RUBBISH, 1: BINARY_RUBBISH, 2: _IN_CBOR, 3: _IN_CBOR}.get(number, _NEARLY_RIGHT)
)
"""A text frame, or ``bytes`` of a binary one, of which most are CBOR; one in ten is garbage."""

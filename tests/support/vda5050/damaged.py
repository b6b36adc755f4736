"""Messages of VDA 5050 with damage: a value replaced, a field removed, or bytes changed."""

import json
from itertools import product
from typing import Any

from hypothesis import strategies as st

from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import BODIES, encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.topics import AgvAddress, Version
from tests.support.vda5050.messages import MESSAGES

TOPICS_2 = (*topics.FROM_AGV, *topics.TO_AGV)
HERE = [(version, topic) for version, topic in product(Version, BODIES) if version.major >= 3 or topic in TOPICS_2]
"""Versions with the topics that they have."""


def payload_of(version: Version, topic: str) -> bytes:
    """Return a message of a topic with all that it may have."""
    counter = HeaderCounter(version, AgvAddress.of(version, "ppaas", "tb1"))
    return encode(topic, counter.next(topic, 1_790_000_000.125), MESSAGES[topic], version)


json_values: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@st.composite
def damaged(draw: st.DrawFn) -> tuple[Version, str, bytes]:
    """Draw a message with a value replaced, a field removed, or bytes changed."""
    version, topic = draw(st.sampled_from(HERE))
    payload = payload_of(version, topic)
    if draw(st.booleans()):
        at = draw(st.integers(0, len(payload) - 1))
        return version, topic, payload[:at] + draw(st.binary(max_size=4)) + payload[at + draw(st.integers(0, 4)) :]
    tree = json.loads(payload)
    place = tree
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = draw(st.sampled_from(keys))
        if isinstance(place[key], dict | list) and place[key] and draw(st.booleans()):
            place = place[key]
            continue
        if draw(st.booleans()):
            place[key] = draw(json_values)
        else:
            del place[key]
        return version, topic, json.dumps(tree).encode()

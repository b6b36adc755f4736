"""Frames waiting for one client are bounded and in order, and expired commands are not sent."""

import json

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.sessions.outbox import MAX_BYTES, MAX_KEEP, MAX_SENT, MAX_SENT_BYTES, MOST_CONNECTS, FrameOutbox
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.nodes.topics import CMD_VEL
from ppaas.wire.fragments import LEAST_SIZE, FragmentAssembler
from ppaas.wire.operations import Fragment
from tests.support.network.still_socket import Connection, sent


def test_only_the_newest_command_is_kept_and_it_expires() -> None:
    clock = ManualClock()
    outbox = FrameOutbox(clock)
    outbox.put("cmd_vel", b"old", keep=1)
    outbox.put("cmd_vel", b"new", keep=1)
    assert sent(outbox) == ["new"]
    outbox.put("cmd_vel", b"stale", keep=1)
    clock.advance(CMD_VEL.expiry)
    assert sent(outbox) == []


def test_drops_of_a_slow_connection_and_connections_are_noted_with_their_times() -> None:
    clock = ManualClock()
    outbox, slow = FrameOutbox(clock), Connection(room=0)
    outbox.put("cmd_vel", b"replaced while nobody was connected", keep=1)
    outbox.put("cmd_vel", b"first", keep=1)
    assert (outbox.connected, outbox.dropped) == (False, 0)
    clock.advance(5.0)
    outbox.connect(slow)
    outbox.put("cmd_vel", b"second", keep=1)
    assert (outbox.connected, outbox.dropped, outbox.dropped_at) == (True, 1, clock())
    assert list(outbox.connected_at) == [clock()]
    outbox.connect(None)
    assert not outbox.connected
    for _ in range(100):
        outbox.connect(slow)
    assert len(outbox.connected_at) == MOST_CONNECTS


def test_answers_are_never_dropped_and_their_number_is_bounded() -> None:
    outbox = FrameOutbox()
    for number in range(10 * MAX_KEEP):
        outbox.put_answer(str(number).encode())
    with pytest.raises(Unavailable):
        outbox.put_answer(b"one too many")


def test_dropped_frames_free_their_capacity() -> None:
    outbox = FrameOutbox()
    for number in range(100 * MAX_KEEP):
        outbox.put("cmd_vel", str(number).encode(), keep=1)
    assert len(outbox) == 1
    outbox.put_answer(b"still served")
    assert len(outbox) == 2


def test_frames_are_sent_at_once_or_when_the_connection_is_ready() -> None:
    outbox, connection = FrameOutbox(), Connection(room=1)
    outbox.connect(connection)
    outbox.put("a", b"at once", keep=1)
    assert connection.sent == ["at once"]
    outbox.put("a", b"dropped", keep=1)
    outbox.put("a", b"later", keep=1)
    outbox.put_answer(b"answer")
    assert connection.sent == ["at once"]
    connection.room = 3
    outbox.flush()
    assert connection.sent == ["at once", "later", "answer"]
    outbox.connect(None)
    connection.room = 9
    outbox.put_answer(b"for the next connection")
    assert connection.sent == ["at once", "later", "answer"]
    assert sent(outbox) == ["for the next connection"]


def test_frames_sent_at_once_are_counted_and_resumable() -> None:
    outbox = FrameOutbox()
    outbox.repeats = True
    outbox.connect(Connection())
    for frame in (b"a", b"b"):
        outbox.put_answer(frame)
    outbox.connect(None)
    outbox.resume(received=1)
    assert sent(outbox) == ["b"]


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers(1, 4)), max_size=60))
def test_each_topic_keeps_its_newest_frames_in_order(puts: list[tuple[str, int]]) -> None:
    keep = {"a": 1, "b": 2, "c": 5}

    outbox = FrameOutbox(ManualClock())
    for number, (topic, _) in enumerate(puts):
        outbox.put(topic, f"{topic}{number}".encode(), keep[topic])
    frames = sent(outbox)
    for topic, length in keep.items():
        put = [f"{topic}{number}" for number, (name, _) in enumerate(puts) if name == topic]
        assert [frame for frame in frames if frame[0] == topic] == put[-length:]
    numbers = [int(frame[1:]) for frame in frames]
    assert numbers == sorted(numbers)


MIB = 1 << 20


def test_the_oldest_droppable_frames_are_dropped_over_the_byte_limit() -> None:
    outbox = FrameOutbox()
    outbox.put("plan", b"p" * MIB, keep=1000)
    outbox.put("move_base/result", b"r" * MIB, keep=1000)
    outbox.put_answer(b"a" * MIB)
    for number in range(20):
        outbox.put("plan", f"{number:02}".encode() + b"q" * MIB, keep=1000)
    left = sent(outbox)
    assert [frame[0] for frame in left[:2]] == ["r", "a"]
    assert sum(map(len, left)) <= MAX_BYTES + MIB
    assert left[-1].startswith("19")
    assert "p" * MIB not in left


def test_answers_over_the_byte_limit_raise_unavailable() -> None:
    outbox = FrameOutbox()
    outbox.put("plan", b"p" * MIB, keep=1)
    for _ in range(MAX_BYTES // MIB):
        outbox.put_answer(b"a" * MIB)
    with pytest.raises(Unavailable):
        outbox.put_answer(b"a")
    assert len(outbox) == MAX_BYTES // MIB, "droppable frames are dropped first"


def test_one_message_over_the_byte_limit_is_sent() -> None:
    outbox = FrameOutbox()
    outbox.put("map", b"m" * (MAX_BYTES + 1), keep=1)
    outbox.put("camera", b"c" * (MAX_BYTES + 1), keep=1)
    assert [frame[0] for frame in sent(outbox)] == ["m", "c"]


# -- frames sent and lost ----------------------------------------------------------------------------------------------


def test_unreceived_lasting_frames_are_resent_first_and_in_order() -> None:
    outbox = FrameOutbox()
    outbox.repeats = True
    outbox.put_answer(b"answer 1")
    outbox.put("plan", b"plan 2", keep=1)
    outbox.put("move_base/result", b"result 3", keep=1)
    outbox.put_answer(b"answer 4")
    outbox.put_answer(b"answer 5")
    sent(outbox, 4)
    outbox.resume(received=1)
    assert sent(outbox, 3) == ["result 3", "answer 4", "answer 5"]
    outbox.resume(received=3)
    assert sent(outbox) == ["answer 5"], "it was the fourth frame sent to the client since"
    outbox.resume(received=4)
    assert sent(outbox) == []


def test_sent_frames_are_retained_within_bounds_if_resumable() -> None:
    silent, outbox = FrameOutbox(), FrameOutbox()
    outbox.repeats = True
    for box in (silent, outbox):
        box.put_answer(b"x" * (MAX_SENT_BYTES + 1))
        for number in range(MAX_SENT + 10):
            box.put_answer(str(number).encode())
        sent(box, MAX_SENT + 11)
        box.resume(received=0)
    assert sent(outbox) == [str(number) for number in range(10, MAX_SENT + 10)]
    assert sent(silent) == []


# -- fragments ---------------------------------------------------------------------------------------------------------


def joined(frames: list[str]) -> list[str]:
    """Return frames with those in fragments put together, as a client does."""
    assembler = FragmentAssembler()
    found = [
        assembler.add(msgspec.json.decode(frame, type=Fragment)) if "fragment" in frame else frame for frame in frames
    ]
    return [frame for frame in found if frame is not None]


LONG = b"x" * 4096


def test_a_long_frame_is_sent_in_fragments_before_the_next() -> None:
    outbox = FrameOutbox()
    outbox.put("map", LONG, keep=1, fragment_size=1024)
    outbox.put_answer(b"short", fragment_size=1024)
    outbox.put_answer(LONG)
    frames = sent(outbox)
    assert len(frames) == 6 and frames[4:] == ["short", LONG.decode()]
    assert joined(frames[:4]) == [LONG.decode()]


def test_fragments_wait_for_a_slow_connection_and_are_not_dropped_by_newer_messages() -> None:
    outbox, connection = FrameOutbox(), Connection(room=2)
    outbox.connect(connection)
    for number in range(5):
        outbox.put("map", str(number).encode() + LONG, keep=1, fragment_size=1024)
    assert len(connection.sent) == 2 and len(outbox) == 4
    connection.room = 99
    outbox.flush()
    assert joined(connection.sent) == [str(number) + LONG.decode() for number in (0, 4)]


def test_a_message_that_a_lost_connection_has_in_part_is_sent_again() -> None:
    outbox = FrameOutbox()
    outbox.put_answer(LONG, fragment_size=1024)
    outbox.put_answer(b"next")
    assert joined(sent(outbox, count=3)) == []
    assert joined(sent(outbox)) == [LONG.decode(), "next"]


@pytest.mark.parametrize("received", [0, 1, 2, 3])
def test_a_client_that_counts_frames_gets_the_fragments_that_it_has_not(received: int) -> None:
    outbox = FrameOutbox()
    outbox.repeats = True
    outbox.put_answer(LONG, fragment_size=1024)
    outbox.put_answer(b"next")
    first = sent(outbox, count=3)
    outbox.resume(received)
    assert joined(first[:received] + sent(outbox)) == [LONG.decode(), "next"]


def test_frames_wait_while_the_outbox_is_corked_and_keep_their_order() -> None:
    outbox, sink = FrameOutbox(), Connection(room=9)
    outbox.connect(sink)
    told: list[str] = []
    with outbox.corked():
        outbox.put_answer(b"one", sent=lambda: told.append("one"))
        with outbox.corked():
            outbox.put("", b"two", 8)
        assert (sink.sent, told) == ([], [])
    assert (sink.sent, told) == (["one", "two"], ["one"])


# -- urgent topics -----------------------------------------------------------------------------------------------------


def test_velocities_overtake_all_that_waits() -> None:
    outbox = FrameOutbox()
    outbox.put("map", b"map", keep=1)
    outbox.put_answer(b"answer")
    outbox.put("cmd_vel", b"old", keep=1)
    outbox.put("cmd_vel", b"velocity", keep=1)
    outbox.put("teleop_state", b"state", keep=1)
    assert sent(outbox) == ["velocity", "state", "map", "answer"]


def test_a_velocity_is_sent_between_the_fragments_of_a_map() -> None:
    outbox, slow = FrameOutbox(), Connection(room=1)
    outbox.put("map", b"x" * 2000, keep=1, fragment_size=LEAST_SIZE)
    outbox.connect(slow)
    outbox.put("cmd_vel", b"velocity", keep=1)
    slow.room = float("inf")
    outbox.flush()
    assert slow.sent[1] == "velocity"
    assert [json.loads(frame)["num"] for frame in slow.sent if frame != "velocity"] == [0, 1]


def test_an_urgent_frame_counts_and_expires_like_any_other() -> None:
    clock = ManualClock()
    outbox = FrameOutbox(clock)
    outbox.put("cmd_vel", b"stale", keep=1)
    clock.advance(CMD_VEL.expiry)
    outbox.put("map", b"map", keep=1)
    assert (sent(outbox), outbox.count, len(outbox)) == (["map"], 1, 0)


def test_velocities_that_wait_for_a_client_that_is_away_do_not_add_up() -> None:
    outbox = FrameOutbox()
    for number in range(10_000):
        outbox.put("cmd_vel", str(number).encode(), keep=2)
    assert len(outbox) == 2
    assert sent(outbox) == ["9998", "9999"]

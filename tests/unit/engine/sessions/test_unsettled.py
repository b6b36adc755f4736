"""Frames of a client that are not settled: for as long as there is a reason, and not longer."""

from collections.abc import Callable

from engine.protocols.session_frames import NumberedFrame
from engine.sessions.unsettled import UnsettledFrames


def _execute(unsettled: UnsettledFrames, number: int) -> None:
    unsettled.begin(NumberedFrame(number, b""))
    unsettled.gather(())


def _numbers(unsettled: UnsettledFrames) -> list[int]:
    return [frame.number for frame in unsettled.frames()]


def test_frame_without_a_reason_is_settled_at_its_end() -> None:
    unsettled = UnsettledFrames()
    _execute(unsettled, 1)
    assert _numbers(unsettled) == [1]
    unsettled.end()
    assert (_numbers(unsettled), unsettled.take_settled(), unsettled.take_settled()) == ([], [1], [])


def test_message_is_settled_by_its_acknowledgement_only() -> None:
    unsettled = UnsettledFrames()
    for number in (1, 2):
        _execute(unsettled, number)
        unsettled.until_acknowledged(10 * number)
        unsettled.end()
    unsettled.acknowledged(19)
    assert (_numbers(unsettled), unsettled.take_settled()) == ([2], [1])


def test_standing_operation_is_settled_by_its_successor_and_by_its_withdrawal() -> None:
    unsettled = UnsettledFrames()
    for number in (1, 2):
        _execute(unsettled, number)
        unsettled.until_withdrawn(("subscription", "map", "a"))
        unsettled.end()
    assert _numbers(unsettled) == [2]
    unsettled.withdrawn("subscription", "map")
    assert _numbers(unsettled) == []


def test_fragments_are_settled_with_their_last_though_others_come_between() -> None:
    unsettled = UnsettledFrames()
    unsettled.begin(NumberedFrame(1, b""))
    unsettled.gather({"a"})
    unsettled.wait_for_rest("a")
    unsettled.begin(NumberedFrame(2, b""))
    unsettled.gather({"a"})
    unsettled.end()
    assert _numbers(unsettled) == [1]
    _execute(unsettled, 3)
    unsettled.end()
    assert sorted(unsettled.take_settled()) == [1, 2, 3]


def test_answered_frame_is_settled_once_its_answer_is_sent() -> None:
    unsettled = UnsettledFrames()
    sent: list[Callable[[], None]] = []
    _execute(unsettled, 1)
    unsettled.answer(sent.append)
    unsettled.end()
    assert (len(sent), _numbers(unsettled)) == (1, [1])
    sent[0]()
    assert unsettled.take_settled() == [1]

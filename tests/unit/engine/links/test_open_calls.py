"""Open calls: each ends once, and a caller that fails concerns no other."""

import pytest

from engine.links.open_calls import OpenCalls, Outcome
from ppaas.errors import Unavailable
from tests.support.waiting import until


def fail(outcome: Outcome) -> None:
    raise RuntimeError(str(outcome))


async def test_a_caller_that_fails_concerns_neither_the_one_that_answers_nor_other_calls() -> None:
    calls, heard = OpenCalls(), list[Outcome]()
    first = calls.open("plan", 60.0, fail)
    calls.open("plan", 60.0, fail)
    calls.open("plan", 60.0, heard.append)
    calls.end(first, b"{}")
    lost = Unavailable("lost")
    calls.fail(lost)
    assert heard == [lost] and list(calls) == []


async def test_a_call_ends_once() -> None:
    calls, heard = OpenCalls(), list[Outcome]()
    number = calls.open("plan", 60.0, heard.append)
    calls.end(number, b"1")
    calls.end(number, b"2")
    calls.fail(Unavailable("lost"))
    assert heard == [b"1"]


async def test_a_call_without_an_answer_ends_with_the_name_of_its_service() -> None:
    calls, heard = OpenCalls(), list[Outcome]()
    calls.open("plan", 0.0, heard.append)
    await until(lambda: bool(heard))
    assert isinstance(heard[0], Unavailable) and "'plan' did not answer within 0 s" in str(heard[0])
    assert list(calls) == []


async def test_a_call_that_was_given_up_does_not_end() -> None:
    calls, heard = OpenCalls(), list[Outcome]()
    assert calls.give_up(calls.open("plan", 0.0, heard.append)) is not None
    with pytest.raises(KeyError):
        calls[1]
    calls.end(1, b"{}")
    assert heard == []

"""Calls over real sockets between two ends, each of which serves methods to the other."""

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any, Protocol

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.calls.caller import Call, Caller, Frame, Result
from engine.calls.interface import wire_name
from engine.protocols.framing import FrameStream
from ppaas.errors import (
    Conflict,
    InvalidInput,
    MalformedMessage,
    NotFound,
    PPaaSError,
    Queued,
    QuotaExceeded,
    Unavailable,
)
from ppaas.tracing.spans import entry
from tests.support.budget import examples
from tests.support.engine.engine_links import connection, pair, receive
from tests.support.recorded_spans import recorded_spans
from tests.support.waiting import patience, until


class Visit(msgspec.Struct, frozen=True):
    """Struct that is passed by calls."""

    robot: str
    pose: tuple[float, float, float]
    seen: dict[str, bytes]
    after: "Visit | None" = None


class DeskCalls(Protocol):
    """Methods that the desk serves."""

    async def mirror(self, visit: Visit) -> Visit: ...

    async def fail(self) -> None: ...

    async def crash(self) -> int: ...

    async def wait(self) -> int: ...

    async def note(self, word: str) -> None: ...

    async def ask_back(self, word: str) -> str: ...


class SumCalls(Protocol):
    """Methods that another object of the desk serves."""

    async def add(self, one: int, other: int) -> int: ...


class NewerCalls(Protocol):
    """Methods of the desk in another release."""

    @wire_name("SumCalls.add")
    async def add(self, one: str) -> int: ...

    async def subtract(self, one: int) -> int: ...

    async def _secret(self) -> int: ...


class VisitorCalls(Protocol):
    """Methods that the visitor serves."""

    async def shout(self, word: str) -> str: ...


class Desk:
    """One end, with a caller for methods of the other."""

    def __init__(self) -> None:
        self.caller: Caller
        self.error: Exception = Conflict("not now")
        self.may_end = asyncio.Event()
        self.ended = 0
        self.noted: list[str] = []

    async def mirror(self, visit: Visit) -> Visit:
        return visit

    async def fail(self) -> None:
        raise self.error

    async def crash(self) -> int:
        return 1 // 0

    async def wait(self) -> int:
        await self.may_end.wait()
        self.ended += 1
        return self.ended

    async def note(self, word: str) -> None:
        if word == "refuse":
            raise Conflict("no more notes")
        if word == "crash":
            raise ZeroDivisionError
        self.noted.append(word)

    async def ask_back(self, word: str) -> str:
        return await self.caller.call(VisitorCalls.shout, word)

    async def _secret(self) -> int:
        return 42


class Sums:
    """Another object that serves methods of the desk."""

    async def add(self, one: int, other: int) -> int:
        return one + other


class Visitor:
    """The other end."""

    async def shout(self, word: str) -> str:
        return word.upper()


class Ends:
    """Both ends of a link."""

    async def start(self) -> "Ends":
        self.desk = Desk()
        near, far = await pair(Frame, Frame)
        self.caller = Caller(near, {VisitorCalls: Visitor()})
        self.desk.caller = Caller(far, {DeskCalls: self.desk, SumCalls: Sums()})
        self.near, self.far = near, far
        self._serving = [asyncio.create_task(each.serve()) for each in (self.caller, self.desk.caller)]
        return self

    async def close(self) -> None:
        await self.near.close()
        await self.far.close()
        await asyncio.gather(*self._serving)


@pytest.fixture
async def ends() -> AsyncIterator[Ends]:
    made = await Ends().start()
    yield made
    await made.close()


# -- results -----------------------------------------------------------------------------------------------------------


async def test_results_come_back_from_each_object_that_serves(ends: Ends) -> None:
    assert await ends.caller.call(SumCalls.add, 2, 3) == 5
    visit = Visit("tb1", (1.0, 2.0, 0.5), {"scan": b"\xff\x00"}, Visit("tb2", (0.0, 0.0, 0.0), {}))
    assert await ends.caller.call(DeskCalls.mirror, visit) == visit


async def test_calls_go_both_ways_at_once(ends: Ends) -> None:
    words = [f"word {number}" for number in range(20)]
    calls = [ends.caller.call(DeskCalls.ask_back, word) for word in words]
    assert await asyncio.gather(*calls) == [word.upper() for word in words]


async def test_a_call_is_part_of_the_trace_of_its_caller(ends: Ends) -> None:
    with recorded_spans() as recorded:
        assert await ends.caller.call(SumCalls.add, 1, 1) == 2
        with entry("request", ""):
            assert await ends.caller.call(DeskCalls.ask_back, "word") == "WORD"
            with pytest.raises(Conflict):
                await ends.caller.call(DeskCalls.fail)
    back, asked, failed, request = recorded
    assert [span.name for span in recorded] == ["VisitorCalls.shout", "DeskCalls.ask_back", "DeskCalls.fail", "request"]
    assert (back.parent, asked.parent, failed.parent) == (asked.id, request.id, request.id)
    assert (asked.error, failed.error) == ("", "conflict")


async def test_a_slow_call_does_not_hold_up_the_next(ends: Ends) -> None:
    slow = asyncio.create_task(ends.caller.call(DeskCalls.wait))
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2
    assert not slow.done()
    ends.desk.may_end.set()
    assert await slow == 1


async def test_a_call_runs_to_its_end_although_nobody_waits_any_more(ends: Ends) -> None:
    waits = asyncio.create_task(ends.caller.call(DeskCalls.wait))
    await ends.caller.call(SumCalls.add, 1, 1)
    waits.cancel()
    await asyncio.gather(waits, return_exceptions=True)
    ends.desk.may_end.set()
    await until(lambda: ends.desk.ended == 1)
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2, "the late result disturbs no other call"


VISITS = st.builds(
    Visit,
    st.text(),
    st.tuples(*[st.floats(allow_nan=False)] * 3),
    st.dictionaries(st.text(max_size=5), st.binary()),
    st.none() | st.builds(Visit, st.text(), st.just((0.0, -0.0, 1e-300)), st.just({})),
)


@settings(max_examples=examples(50), deadline=None)
@given(visits=st.lists(VISITS, max_size=5))
def test_structs_come_back_equal(visits: list[Visit]) -> None:
    async def mirror_all() -> list[Visit]:
        ends = await Ends().start()
        try:
            return await asyncio.gather(*(ends.caller.call(DeskCalls.mirror, visit) for visit in visits))
        finally:
            await ends.close()

    assert asyncio.run(mirror_all()) == visits


# -- errors ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "facts"),
    [
        (Conflict("not now"), None),
        (NotFound("machine", "m7", ["m1"]), None),
        (QuotaExceeded("too many paths", retry_after=2.5), lambda error: error.retry_after),
        (QuotaExceeded("too many containers"), lambda error: error.retry_after),
        (Queued(3), lambda error: error.position),
    ],
    ids=["conflict", "not found", "quota with a time", "quota without a time", "queued"],
)
async def test_an_error_arrives_with_its_type_text_and_facts(
    ends: Ends, error: PPaaSError, facts: Callable[[Any], object] | None
) -> None:
    ends.desk.error = error
    with pytest.raises(PPaaSError) as raised:
        await ends.caller.call(DeskCalls.fail)
    assert (type(raised.value), str(raised.value)) == (type(error), str(error))
    if facts is not None:
        assert facts(raised.value) == facts(error)


async def test_a_text_for_operators_stays_here(ends: Ends, caplog: pytest.LogCaptureFixture) -> None:
    ends.desk.error = Unavailable("/var/lib/disk is full", public="the cloud has no room")
    with pytest.raises(Unavailable, match=r"^the cloud has no room$"):
        await ends.caller.call(DeskCalls.fail)
    assert "/var/lib/disk is full" in caplog.text


async def test_an_internal_error_is_logged_and_told_by_its_type_only(
    ends: Ends, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(PPaaSError, match=r"^internal error: ZeroDivisionError$") as raised:
        await ends.caller.call(DeskCalls.crash)
    assert type(raised.value) is PPaaSError
    assert "a call of 'DeskCalls.crash' failed" in caplog.text
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2


async def test_a_method_of_another_release_is_refused(ends: Ends) -> None:
    with pytest.raises(InvalidInput, match=r"calls 'NewerCalls\.subtract', which this release does not have"):
        await ends.caller.call(NewerCalls.subtract, 1)
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2


async def test_arguments_of_another_release_are_refused(ends: Ends) -> None:
    with pytest.raises(InvalidInput, match=r"the arguments of 'SumCalls\.add' are those of another release"):
        await ends.caller.call(NewerCalls.add, "one")
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2


async def test_a_private_method_cannot_be_called(ends: Ends) -> None:
    with pytest.raises(InvalidInput, match="does not have"):
        await ends.caller.call(NewerCalls._secret)


# -- notices -----------------------------------------------------------------------------------------------------------


async def test_notices_are_handled_in_order_without_an_answer(ends: Ends) -> None:
    for word in ("one", "two"):
        ends.caller.tell(DeskCalls.note, word)
    await until(lambda: len(ends.desk.noted) == 2)
    assert ends.desk.noted == ["one", "two"]


@pytest.mark.parametrize(
    ("word", "logged"),
    [("refuse", "a notice 'DeskCalls.note' failed: no more notes"), ("crash", "a background task failed")],
)
async def test_a_notice_that_fails_is_logged_and_the_link_lives_on(
    ends: Ends, caplog: pytest.LogCaptureFixture, word: str, logged: str
) -> None:
    ends.caller.tell(DeskCalls.note, word)
    await until(lambda: logged in caplog.text)
    assert await ends.caller.call(SumCalls.add, 1, 1) == 2


# -- the link ----------------------------------------------------------------------------------------------------------


async def test_calls_that_wait_fail_when_the_link_is_lost_and_so_do_later_ones(ends: Ends) -> None:
    waits = asyncio.create_task(ends.caller.call(DeskCalls.wait))
    await ends.caller.call(SumCalls.add, 1, 1)
    ends.far.abort()
    with pytest.raises(Unavailable, match="try again"):
        async with patience(10.0):
            await waits
    with pytest.raises(Unavailable, match="try again"):
        async with patience(10.0):
            await ends.caller.call(SumCalls.add, 1, 1)
    await ends.close()
    ends.desk.may_end.set()
    await asyncio.sleep(0)
    assert ends.desk.ended == 0, "the desk has cancelled the call when it lost the link"


async def test_an_end_that_violates_the_protocol_ends_the_link() -> None:
    stream: FrameStream[Frame]
    stream, _, writer = await connection(Frame)
    caller = Caller(stream, {DeskCalls: Desk()})
    writer.write(b"\x00\x00\x00\x01\xc1")
    with pytest.raises(MalformedMessage):
        async with patience(10.0):
            await caller.serve()
    writer.close()
    await stream.close()


async def test_an_answer_to_no_call_is_ignored(ends: Ends) -> None:
    """A late result of a call that nobody waits for any more has a number that is not known."""
    near, far = await pair(Frame, Frame)
    serving = asyncio.create_task(Caller(far, {SumCalls: Sums()}).serve())
    near.write(Result(9, msgspec.Raw(b"\x01")))
    near.write(Call(1, "SumCalls.add", msgspec.Raw(msgspec.msgpack.encode((1, 1)))))
    answer = await receive(near)
    assert (answer.number, msgspec.msgpack.decode(answer.value)) == (1, 2)
    await near.close()
    await serving
    await far.close()

"""Spans of a container, handed over to its machine."""

import asyncio
from typing import cast

import pytest

from engine.container.machine_client import MachineClient
from engine.container.spans import MAX_WAITING, MOST, WaitingSpans, hand_over_spans, keep_spans
from ppaas.tracing.spans import Sampling, SpanRecord, entry, own_sampling, record_spans
from tests.support.waiting import until


class Machine:
    """Machine that notes what it is handed."""

    def __init__(self) -> None:
        self.waiting = 0
        self.spans = list[SpanRecord]()
        self.dropped = list[int]()

    def spans_ended(self, spans: list[SpanRecord], dropped: int) -> None:
        """Take spans."""
        self.spans += spans
        self.dropped.append(dropped)

    @property
    def link(self) -> MachineClient:
        """Return it as the container knows it."""
        return cast(MachineClient, self)


SPAN = SpanRecord("plan", "internal", "a" * 32, "b" * 16, "", 1.0, 2.0)


def test_further_spans_are_counted_once() -> None:
    machine, waiting = Machine(), WaitingSpans()
    for _ in range(MOST + 3):
        waiting(SPAN)
    for _ in range(2):
        waiting.hand_over(machine.link)
    assert (len(machine.spans), machine.dropped) == (MOST, [3])


def test_spans_wait_while_the_machine_is_busy() -> None:
    machine, waiting = Machine(), WaitingSpans()
    waiting(SPAN)
    machine.waiting = MAX_WAITING + 1
    waiting.hand_over(machine.link)
    assert not machine.spans
    machine.waiting = 0
    waiting.hand_over(machine.link)
    assert machine.spans == [SPAN]


async def test_spans_go_to_the_machine_those_of_the_end_as_well() -> None:
    machine = Machine()
    keep_spans(Sampling(0.5, False))
    assert own_sampling() == Sampling(0.5, False)
    keep_spans(Sampling())
    handing = asyncio.create_task(hand_over_spans(machine.link))
    with entry("goal", ""):
        pass
    await until(lambda: machine.spans)
    with entry("last goal", ""):
        pass
    handing.cancel()
    with pytest.raises(asyncio.CancelledError):
        await handing
    record_spans(None)
    assert [span.name for span in machine.spans] == ["goal", "last goal"]

"""Spans of a container, which its machine exports: a container has no network, and packages of exporters cost memory.

Only a machine that exports spans orders them (`Launch.traces`).
"""

import asyncio
from collections import deque

from engine.container.machine_client import MachineClient
from ppaas.tracing.spans import Sampling, SpanRecord, record_spans

PERIOD = 0.5
"""Time between two reports [s]."""

MOST = 1000
"""Number of spans that wait for the next report; further ones are dropped."""

MAX_WAITING = 1 << 20
"""Bytes queued for the machine above which spans wait: they go after what robots wait for."""


class WaitingSpans:
    """Spans that have ended; taken from any thread, and handed over by the event loop."""

    def __init__(self) -> None:
        self._spans: deque[SpanRecord] = deque()
        self._dropped = 0

    def __call__(self, span: SpanRecord) -> None:
        """Take a span."""
        if len(self._spans) < MOST:
            self._spans.append(span)
        else:
            self._dropped += 1

    def hand_over(self, machine: MachineClient) -> None:
        """Hand the spans to the machine."""
        if machine.waiting > MAX_WAITING or not (self._spans or self._dropped):
            return
        spans = [self._spans.popleft() for _ in range(len(self._spans))]
        dropped, self._dropped = self._dropped, 0
        machine.spans_ended(spans, dropped)


_waiting = WaitingSpans()


def keep_spans(sampling: Sampling) -> None:
    """Record the spans of this process, and keep them for its machine."""
    record_spans(_waiting, sampling)


async def hand_over_spans(machine: MachineClient) -> None:
    """Hand spans to the machine until cancelled, those of the end as well."""
    try:
        while True:
            await asyncio.sleep(PERIOD)
            _waiting.hand_over(machine)
    finally:
        _waiting.hand_over(machine)

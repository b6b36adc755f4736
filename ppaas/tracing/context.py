"""Trace context: the trace that this task or thread works for, and its text in headers and frames (W3C)."""

import re
from contextvars import ContextVar
from typing import NamedTuple

_FORM = re.compile(r"([0-9a-f]{2})-([0-9a-f]{32})-([0-9a-f]{16})-([0-9a-f]{2})(-.*)?", re.ASCII)


class TraceContext(NamedTuple):
    """Place in a trace.

    Parameters
    ----------
    trace : str
        Id of the trace, 32 hexadecimal digits.
    span : str
        Id of the span, 16 hexadecimal digits.
    sampled : bool
        Whether spans of the trace are recorded.
    """

    trace: str
    span: str
    sampled: bool

    def __str__(self) -> str:
        return f"00-{self.trace}-{self.span}-0{self.sampled:d}"


def context_of(traceparent: str) -> TraceContext | None:
    """Return the context of a ``traceparent``; None if it is not valid, and so does not count."""
    found = _FORM.fullmatch(traceparent)
    if found is None:
        return None
    version, trace, span, flags, rest = found.groups()
    if version == "ff" or (version == "00" and rest) or not (trace.strip("0") and span.strip("0")):
        return None
    return TraceContext(trace, span, bool(int(flags, 16) & 1))


current: ContextVar[TraceContext | None] = ContextVar("trace", default=None)
"""Context of this task or thread; None if it works for no trace, as always while no traces are recorded."""

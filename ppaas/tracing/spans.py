"""Spans: what a process does for a request or a goal, and for how long.

While no traces are recorded, nothing is: all functions return `NOTHING`, or what they were given.
"""

import functools
import secrets
from collections.abc import Callable
from contextvars import Token
from typing import Any, Literal, ParamSpec, Protocol, Self, TypeVar, cast

import msgspec

from ppaas.clock import epoch
from ppaas.errors import PlanCancelled, PPaaSError
from ppaas.log_lines import log_also
from ppaas.tracing.context import TraceContext, context_of, current

Kind = Literal["internal", "server", "client"]
"""Role of a span: it serves a request of another process, makes one, or neither."""

Attribute = str | bool | int | float

LONGEST = 256
"""Number of characters after which texts of attributes and errors are cut."""

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")


class SpanRecord(msgspec.Struct):
    """What is recorded of a span.

    Parameters
    ----------
    name : str
        What was done; one of few names.
    kind : Kind
        Its role.
    trace, id, parent : str
        Ids of the trace, of the span, and of the span that it is a part of, hexadecimal; no parent is empty.
    began, ended : float
        Its time [s since the epoch].
    attributes : dict of str to Attribute
        What it was done with, by the names of OpenTelemetry.
    error, message : str
        Type and text of the error with which it ended; empty if it ended well.
    """

    name: str
    kind: Kind
    trace: str
    id: str
    parent: str
    began: float
    ended: float = 0.0
    attributes: dict[str, Attribute] = {}
    error: str = ""
    message: str = ""


class Sampling(msgspec.Struct, frozen=True):
    """Decides which traces are recorded, as OpenTelemetry's samplers do.

    Parameters
    ----------
    ratio : float
        Part of the traces.
    follows_parent : bool
        Whether the decision of a client counts instead, where it has made one.
    """

    ratio: float = 1.0
    follows_parent: bool = True

    def takes(self, trace: str, parent: TraceContext | None) -> bool:
        """Return whether a trace is recorded that begins here, or that a client has begun."""
        if parent is not None and self.follows_parent:
            return parent.sampled
        return int(trace[16:], 16) < round(self.ratio * (1 << 64))


class Recorder(Protocol):
    """Takes spans that have ended; may be called by any thread, and must not block."""

    def __call__(self, span: SpanRecord) -> None:
        """Take a span."""
        ...


_recorder: Recorder | None = None
_sampling = Sampling()


def record_spans(recorder: Recorder | None, sampling: Sampling | None = None) -> None:
    """Record the spans of this process from now on; with None, record no more."""
    global _recorder, _sampling
    _recorder, _sampling = recorder, sampling or Sampling()
    log_also(_log_members)


def _log_members() -> dict[str, str]:
    context = current.get()
    return {} if context is None else {"trace_id": context.trace, "span_id": context.span}


def are_recorded() -> bool:
    """Return whether this process records spans."""
    return _recorder is not None


def own_sampling() -> Sampling | None:
    """Return which traces this process begins; None if it records no spans."""
    return None if _recorder is None else _sampling


def traceparent() -> str:
    """Return the context of this task or thread, for another process; empty if there is none."""
    context = current.get()
    return "" if context is None else str(context)


# -- one span ----------------------------------------------------------------------------------------------------------


class Within:
    """Context manager in which a task or thread works for a trace; for none, it changes nothing."""

    __slots__ = ("_context", "_token")

    def __init__(self, context: TraceContext | None) -> None:
        self._context = context
        self._token: Token[TraceContext | None] | None = None

    def __enter__(self) -> None:
        if self._context is not None:
            self._token = current.set(self._context)

    def __exit__(self, *_: object) -> None:
        if self._token is not None:
            current.reset(self._token)


class Span:
    """Span that has begun. As a context manager, it ends with its block, and the block is part of its trace.

    Parameters
    ----------
    context : TraceContext, optional
        Its place in its trace; None if there is no trace.
    record : SpanRecord, optional
        What is recorded of it; None if nothing is.
    """

    __slots__ = ("_context", "_record", "_token")

    def __init__(self, context: TraceContext | None, record: SpanRecord | None = None) -> None:
        self._context, self._record = context, record
        self._token: Token[TraceContext | None] | None = None

    def __enter__(self) -> Self:
        if self._context is not None:
            self._token = current.set(self._context)
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _traceback: object) -> None:
        if self._context is None:
            return
        if self._token is not None:
            current.reset(self._token)
        self.end(error)

    def active(self) -> Within:
        """Return a context manager whose block is part of the trace, and does not end the span."""
        return Within(self._context)

    def set(self, attributes: dict[str, Attribute]) -> None:
        """Record attributes."""
        if self._record is not None:
            self._record.attributes.update(_cut(attributes))

    def rename(self, name: str) -> None:
        """Take another name."""
        if self._record is not None:
            self._record.name = name

    def fail(self, kind: str, text: str) -> None:
        """Record an error; the span goes on."""
        if self._record is not None:
            self._record.error, self._record.message = kind, text[:LONGEST]

    def end(self, error: object = None) -> None:
        """End the span, by an error if one is given; one that has ended stays as it is."""
        record, self._record = self._record, None
        if record is None or _recorder is None:
            return
        if isinstance(error, PlanCancelled) or (isinstance(error, BaseException) and not isinstance(error, Exception)):
            record.attributes["ppaas.cancelled"] = True
        elif isinstance(error, BaseException):
            record.error = error.slug if isinstance(error, PPaaSError) else type(error).__name__
            record.message = str(error)[:LONGEST]
        record.ended = epoch()
        _recorder(record)


NOTHING = Span(None)
"""Span of no trace."""


def span(name: str, attributes: dict[str, Attribute] | None = None, kind: Kind = "internal") -> Span:
    """Begin a span of the trace that this task or thread works for; `NOTHING` if there is none."""
    parent = current.get()
    if parent is None or not parent.sampled or _recorder is None:
        return NOTHING
    return _begun(parent, name, attributes, kind)


def served(name: str, parent: str, attributes: dict[str, Attribute] | None = None) -> Span:
    """Begin a span for a request of another process of the cloud, whose ``traceparent`` came with it, if it has one."""
    context = context_of(parent) if parent and _recorder is not None else None
    if context is None:
        return NOTHING
    return _begun(context, name, attributes, "server") if context.sampled else Span(context)


def entry(name: str, parent: str, attributes: dict[str, Attribute] | None = None, kind: Kind = "server") -> Span:
    """Begin a span for a request from outside the cloud: in the trace of the client, or in a new one."""
    if _recorder is None:
        return NOTHING
    found = context_of(parent)
    trace = secrets.token_hex(16) if found is None else found.trace
    context = TraceContext(trace, "" if found is None else found.span, _sampling.takes(trace, found))
    if context.sampled:
        return _begun(context, name, attributes, kind)
    return Span(context._replace(span=context.span or secrets.token_hex(8)))


def within(parent: str) -> Within:
    """Return a context manager whose block works for a trace, given its ``traceparent``; for none, if it is empty."""
    return Within(context_of(parent) if parent and _recorder is not None else None)


def _begun(parent: TraceContext, name: str, attributes: dict[str, Attribute] | None, kind: Kind) -> Span:
    context = parent._replace(span=secrets.token_hex(8))
    record = SpanRecord(name, kind, context.trace, context.span, parent.span, epoch(), attributes=_cut(attributes))
    return Span(context, record)


def _cut(attributes: dict[str, Attribute] | None) -> dict[str, Attribute]:
    given = attributes or {}
    return {name: value[:LONGEST] if isinstance(value, str) else value for name, value in given.items()}


# -- work elsewhere ----------------------------------------------------------------------------------------------------


def carried(work: Callable[P, R]) -> Callable[P, R]:
    """Return a function that works for the trace of this task, whichever thread calls it, and whenever."""
    context = current.get()
    if context is None:
        return work

    @functools.wraps(work)
    def run(*args: P.args, **named: P.kwargs) -> R:
        with Within(context):
            return work(*args, **named)

    return run


class _Traced:
    def __init__(self, target: object, name: str) -> None:
        self._target, self._name = target, name

    def __getattr__(self, attribute: str) -> Any:
        found = getattr(self._target, attribute)
        if attribute.startswith("_") or not callable(found):
            return found
        name = f"{self._name} {attribute}"

        @functools.wraps(found)
        def call(*args: Any, **named: Any) -> Any:
            with span(name, kind="client"):
                return found(*args, **named)

        self.__dict__[attribute] = call  # found there from now on
        return call


def traced(target: T, name: str) -> T:
    """Return an object whose calls are spans of the trace that they are made for; while none are recorded, itself."""
    return cast(T, _Traced(target, name)) if are_recorded() else target

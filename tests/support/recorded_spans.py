"""Spans of a test, recorded in a list."""

from collections.abc import Iterator
from contextlib import contextmanager

from ppaas.tracing.spans import SpanRecord, record_spans


@contextmanager
def recorded_spans() -> Iterator[list[SpanRecord]]:
    """Record the spans of a block; they are in the list in the order of their ends."""
    spans = list[SpanRecord]()
    record_spans(spans.append)
    try:
        yield spans
    finally:
        record_spans(None)

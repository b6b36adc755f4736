"""Recorded spans."""

from collections.abc import Iterator

import pytest

from ppaas.tracing.spans import SpanRecord
from tests.support.recorded_spans import recorded_spans


@pytest.fixture
def recorded() -> Iterator[list[SpanRecord]]:
    """Record the spans of this test; return those that have ended."""
    with recorded_spans() as spans:
        yield spans

"""Export of spans by OTLP over HTTP, in a thread of OpenTelemetry's SDK.

Nothing waits for the receiver. Spans that it does not take in time are dropped, counted and reported in the log.
"""

import logging
import threading
from collections.abc import Sequence

from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
from opentelemetry.sdk.resources import Resource
from opentelemetry.sdk.trace import Event, ReadableSpan
from opentelemetry.sdk.trace.export import BatchSpanProcessor, SpanExporter, SpanExportResult
from opentelemetry.sdk.util.instrumentation import InstrumentationScope
from opentelemetry.trace import SpanContext, SpanKind, Status, StatusCode, TraceFlags

from engine.processes.occasional_log import OccasionalLog
from ppaas import __version__
from ppaas.bounded import BoundedDict
from ppaas.tracing.spans import SpanRecord

logger = logging.getLogger(__name__)

PATH = "/v1/traces"
"""Path of traces below the URL of a receiver (OTLP/HTTP)."""

MOST = 2048
"""Number of spans that wait for the receiver; further ones are dropped."""

BATCH = 512
"""Number of spans that are sent at once."""

PERIOD = 1000
"""Time between two batches [ms]."""

TIMEOUT = 5.0
"""Time within which a receiver takes a batch, with all further attempts [s]."""

ENDING = 1.0
"""Time that the end of a process waits for the last batch [s]."""

MAX_PROCESSES = 1000
"""Number of processes whose resources are kept; others are made again."""

KINDS = {"internal": SpanKind.INTERNAL, "server": SpanKind.SERVER, "client": SpanKind.CLIENT}


class _Reasons(logging.Handler):
    """Keeps the last reason that the exporter logs, for the line that counts dropped spans, and drops its lines.

    Lines with the kind of the batch alone have no reason: they report that the exporter gave up.
    """

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.last = ""

    def emit(self, record: logging.LogRecord) -> None:
        if record.args is not None and len(record.args) > 1:
            self.last = record.getMessage()


class _Counting(SpanExporter):
    """Exporter that counts what it was given, and reports what its receiver has not taken."""

    def __init__(self, exporter: SpanExporter, failed: "SpanExport") -> None:
        self._exporter = exporter
        self._failed = failed
        self.given = 0

    def export(self, spans: Sequence[ReadableSpan]) -> SpanExportResult:
        """Send a batch; on failure, its spans are dropped."""
        self.given += len(spans)
        try:
            result = self._exporter.export(spans)
        except Exception as error:
            logger.debug("a batch of spans was not sent", exc_info=True)
            self._failed.reasons.last, result = str(error), SpanExportResult.FAILURE
        if result is SpanExportResult.SUCCESS:
            self._failed.taken()
        else:
            self._failed.drop(len(spans))
        return result

    def shutdown(self) -> None:
        """End the exporter, also while it sends."""
        self._exporter.shutdown()


class SpanExport:
    """Sends spans to a receiver.

    Parameters
    ----------
    url : str
        URL of the receiver, without the path of traces.

    Attributes
    ----------
    dropped : int
        Number of spans that were dropped.
    """

    def __init__(self, url: str) -> None:
        self._url = url.rstrip("/").removesuffix(PATH) + PATH
        self.dropped = 0
        self._added = 0
        self._lock = threading.Lock()
        self._log = OccasionalLog(logger)
        self.reasons = _Reasons()
        library = logging.getLogger("opentelemetry")
        library.propagate, library.handlers = False, [self.reasons]
        self._counting = _Counting(OTLPSpanExporter(endpoint=self._url, timeout=TIMEOUT), self)
        self._processor = BatchSpanProcessor(
            self._counting, max_queue_size=MOST, schedule_delay_millis=PERIOD, max_export_batch_size=BATCH
        )
        self._scope = InstrumentationScope("ppaas", __version__)
        self._resources: BoundedDict[tuple[str, str], Resource] = BoundedDict(MAX_PROCESSES)

    def add(self, span: SpanRecord, service: str, process: str) -> None:
        """Send a span of a process, or drop it if too many wait; from any thread, at once."""
        with self._lock:
            if self._added - self._counting.given >= MOST:
                full = True
            else:
                full, self._added = False, self._added + 1
        if full:
            self.drop(1)
            return
        self._processor.on_end(self._readable(span, self._resource(service, process)))

    def drop(self, count: int) -> None:
        """Count spans that are dropped, and report them in the log now and then."""
        if not count:
            return
        with self._lock:
            self.dropped += count
            self._log.warning(
                "spans of traces are dropped, %d since the start: %s does not take them: %s",
                self.dropped, self._url, self.reasons.last or "it is too slow",
            )  # fmt: skip

    def taken(self) -> None:
        """Report that the receiver takes spans again, if it did not."""
        with self._lock:
            self._log.is_over("the receiver of traces takes spans again")
        self.reasons.last = ""

    def close(self) -> None:
        """Send what waits, for a short time."""
        ending = threading.Thread(target=self._processor.shutdown, name="last spans", daemon=True)
        ending.start()
        ending.join(ENDING)

    def _resource(self, service: str, process: str) -> Resource:
        key = service, process
        found = self._resources.get(key)
        if found is None:
            found = Resource.create(
                {"service.name": service, "service.instance.id": process, "service.version": __version__}
            )
            self._resources[key] = found
        return found

    def _readable(self, span: SpanRecord, resource: Resource) -> ReadableSpan:
        trace = int(span.trace, 16)
        failure = {"exception.type": span.error, "exception.message": span.message}
        ended = _nanoseconds(span.ended)
        return ReadableSpan(
            name=span.name,
            context=_context(trace, span.id),
            parent=_context(trace, span.parent) if span.parent else None,
            resource=resource,
            attributes=span.attributes | ({"error.type": span.error} if span.error else {}),
            events=[Event("exception", failure, ended)] if span.error else (),
            kind=KINDS[span.kind],
            status=Status(StatusCode.ERROR, span.message) if span.error else Status(),
            start_time=_nanoseconds(span.began),
            end_time=ended,
            instrumentation_scope=self._scope,
        )


def _context(trace: int, span: str) -> SpanContext:
    return SpanContext(trace, int(span, 16), is_remote=False, trace_flags=TraceFlags(TraceFlags.SAMPLED))


def _nanoseconds(seconds: float) -> int:
    return int(seconds * 1e9)

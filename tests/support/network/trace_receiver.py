"""Receiver of traces by OTLP over HTTP, which decodes what exporters of OpenTelemetry send."""

import gzip
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import (
    ExportTraceServiceRequest,
    ExportTraceServiceResponse,
)

from tests.support.waiting import until


@dataclass(frozen=True)
class ReceivedSpan:
    """Span as the receiver got it; ids are hexadecimal, no parent is empty."""

    service: str
    process: str
    name: str
    trace: str
    id: str
    parent: str
    kind: int
    began: int
    ended: int
    failed: bool
    attributes: dict[str, Any]
    events: tuple[tuple[str, dict[str, Any]], ...]


@dataclass
class TraceReceiver:
    """What a receiver has got, and the status with which it answers."""

    url: str = ""
    status: int = 200
    spans: list[ReceivedSpan] = field(default_factory=list)
    requests: int = 0

    def take(self, body: bytes) -> None:
        """Take the body of a request."""
        self.requests += 1
        if self.status != 200:
            return
        for group in ExportTraceServiceRequest.FromString(body).resource_spans:
            resource = _values(group.resource.attributes)
            for scope in group.scope_spans:
                self.spans += [_received(resource, span) for span in scope.spans]

    def of(self, trace: str) -> list[ReceivedSpan]:
        """Return the spans of a trace in the order of their beginnings."""
        return sorted((span for span in self.spans if span.trace == trace), key=lambda span: span.began)

    async def whole(self, trace: str, *names: str) -> list[ReceivedSpan]:
        """Return the spans of a trace, once it has some with these names."""
        await until(lambda: {span.name for span in self.of(trace)} >= set(names))
        return self.of(trace)


def _values(pairs: Any) -> dict[str, Any]:
    return {pair.key: getattr(pair.value, pair.value.WhichOneof("value")) for pair in pairs}


def _received(resource: dict[str, Any], span: Any) -> ReceivedSpan:
    return ReceivedSpan(
        resource["service.name"],
        resource["service.instance.id"],
        span.name,
        span.trace_id.hex(),
        span.span_id.hex(),
        span.parent_span_id.hex(),
        span.kind,
        span.start_time_unix_nano,
        span.end_time_unix_nano,
        span.status.code == span.status.STATUS_CODE_ERROR,
        _values(span.attributes),
        tuple((event.name, _values(event.attributes)) for event in span.events),
    )


@contextmanager
def trace_receiver() -> Iterator[TraceReceiver]:
    """Receive traces on a free port of this host."""
    received = TraceReceiver()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            assert self.path == "/v1/traces", self.path
            received.take(gzip.decompress(body) if self.headers.get("Content-Encoding") == "gzip" else body)
            self.send_response(received.status)
            self.send_header("Content-Type", "application/x-protobuf")
            self.end_headers()
            self.wfile.write(ExportTraceServiceResponse().SerializeToString())

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - of http.server
            """Write no lines."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    received.url = f"http://127.0.0.1:{server.server_address[1]}"
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield received
    finally:
        server.shutdown()
        server.server_close()
        thread.join()

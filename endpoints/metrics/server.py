"""Server of scrapes: a thread beside the process whose metrics it serves."""

import asyncio
import logging
import socket
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from socketserver import ThreadingMixIn
from typing import TYPE_CHECKING, Any
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer

from prometheus_client import CollectorRegistry, ProcessCollector, make_wsgi_app

from endpoints.metrics.collector import CloudCollector
from ppaas.errors import Unavailable

if TYPE_CHECKING:
    from wsgiref.types import StartResponse, WSGIApplication, WSGIEnvironment

logger = logging.getLogger(__name__)

PATH = "/metrics"

ALIVE = "/alive"
"""Path of the question whether the process works, which supervisors ask."""

PATIENCE = 5.0
"""Time that the event loop has to answer this question [s]."""

MOST_CLIENTS = 8
"""Largest number of scrapes at a time; a further connection is closed."""

SILENCE = 10.0
"""Time after which a client that sends no request, or takes no answer, is disconnected [s]."""


class _Handler(WSGIRequestHandler):
    timeout = SILENCE

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the name of the base class
        """Log nothing, as scrapes come all the time."""


class _Server(ThreadingMixIn, WSGIServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int]) -> None:
        self.address_family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self._free = threading.BoundedSemaphore(MOST_CLIENTS)
        super().__init__(address, _Handler)

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Return whether there is a thread for a connection."""
        return self._free.acquire(blocking=False)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a connection."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()


def at_paths(metrics: "WSGIApplication", loop: asyncio.AbstractEventLoop) -> "WSGIApplication":
    """Return an application that serves metrics at `PATH`, and at `ALIVE` whether an event loop works."""

    def serve(environ: "WSGIEnvironment", start_response: "StartResponse") -> Iterable[bytes]:
        if environ["PATH_INFO"] == PATH:
            return metrics(environ, start_response)
        status, text = "404 Not Found", f"metrics are at {PATH}\n"
        if environ["PATH_INFO"] == ALIVE:
            status, text = ("200 OK", "alive\n") if is_alive(loop) else ("503 Service Unavailable", "hangs\n")
        start_response(status, [("Content-Type", "text/plain")])
        return [text.encode()]

    return serve


def is_alive(loop: asyncio.AbstractEventLoop) -> bool:
    """Return whether an event loop, of another thread, answers in time."""
    answering = asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop)
    try:
        answering.result(PATIENCE)
    except (TimeoutError, CancelledError):
        answering.cancel()
        return False
    return True


async def serve_metrics(address: tuple[str, int], *, robots: bool) -> tuple[CloudCollector, Callable[[], None]]:
    """Serve the metrics of this process at an address; return what collects them, and what ends the server.

    Parameters
    ----------
    address : tuple
        Host and port; port 0 takes a free one.
    robots : bool
        Whether robots are listed by name.

    Raises
    ------
    Unavailable
        Listening on the address failed.
    """
    host, port = address
    collector, registry = CloudCollector(asyncio.get_running_loop(), robots=robots), CollectorRegistry()
    registry.register(collector)
    ProcessCollector(registry=registry)
    try:
        server = await asyncio.to_thread(_Server, address)
    except OSError as error:
        raise Unavailable(f"cannot serve metrics at {host}:{port}: {error}") from error
    server.set_app(at_paths(make_wsgi_app(registry), asyncio.get_running_loop()))
    thread = threading.Thread(target=server.serve_forever, name="metrics", daemon=True)
    thread.start()
    logger.info("serving metrics at http://%s:%d%s", host, server.server_port, PATH)

    def end() -> None:
        server.shutdown()
        server.server_close()

    return collector, end

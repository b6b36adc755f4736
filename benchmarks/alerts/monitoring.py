"""Prometheus with the rules of this project, Alertmanager, and a receiver of its notifications, on loopback."""

import asyncio
import contextlib
import json
import re
import shutil
import threading
from asyncio.subprocess import DEVNULL
from collections.abc import AsyncIterator, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import yaml

from benchmarks.harness.free_ports import free_ports
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

RULES = Path(__file__).resolve().parents[2] / "deploy" / "prometheus" / "ppaas.rules.yaml"

PROGRAMS = ("prometheus", "prometheus-alertmanager")

INTERVAL = 15.0
"""Time between two scrapes, without hurry [s]."""

END_TIMEOUT = 10.0
"""Time within which a program must exit after SIGTERM [s]."""

_DURATION = re.compile(r"(?<=for: )(\d+)([smh])\b|(?<=\[)(\d+)([smh])(?=\])")
_SECONDS = {"s": 1.0, "m": 60.0, "h": 3600.0}


def hurried(rules: str, factor: float) -> str:
    """Return rules whose patience and windows are shorter by a factor."""

    def shorter(found: re.Match[str]) -> str:
        number, unit = found[1] or found[3], found[2] or found[4]
        return f"{max(1, round(1e3 * int(number) * _SECONDS[unit] / factor))}ms"

    return _DURATION.sub(shorter, rules)


class Notifications:
    """Alerts as Alertmanager notifies of them, with the times at which each began to fire and was resolved [s]."""

    def __init__(self) -> None:
        self._times: dict[tuple[str, str], list[float]] = {}
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()

    def take(self, alert: str, status: str) -> None:
        """Note an alert that is firing or resolved; in any thread."""
        self._loop.call_soon_threadsafe(self._note, alert, status)

    def _note(self, alert: str, status: str) -> None:
        self._times.setdefault((alert, status), []).append(monotonic())
        self._news.set()
        self._news = asyncio.Event()

    async def when(self, alert: str, status: str, after: float, timeout: float) -> float | None:
        """Wait for an alert to have a status after a time; return when it has it, or None if it does not in time."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while True:
                    found = [time for time in self._times.get((alert, status), ()) if time > after]
                    if found:
                        return found[0]
                    await self._news.wait()
        return None


@contextlib.contextmanager
def receiver(port: int, heard: Notifications) -> Iterator[None]:
    """Take the notifications of Alertmanager at a port of this computer, in a thread."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            for alert in body["alerts"]:
                heard.take(alert["labels"]["alertname"], alert["status"])
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Log nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


@contextlib.asynccontextmanager
async def _program(*command: str, log: Path) -> AsyncIterator[None]:
    with log.open("wb") as output:
        process = await asyncio.create_subprocess_exec(*command, stdin=DEVNULL, stdout=output, stderr=output)
    try:
        yield
        if process.returncode is not None:
            raise Unavailable(f"{command[0]} has exited with status {process.returncode}; its log is {log}")
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
        async with asyncio.timeout(END_TIMEOUT):
            await process.wait()


def _configure(folder: Path, target: int, factor: float, alertmanager: int, heard_at: int) -> None:
    """Write the configuration of both programs, with the ports of the cloud, of Alertmanager and of the receiver."""
    interval = f"{max(1.0, INTERVAL / factor):.0f}s"
    (folder / "rules.yaml").write_text(hurried(RULES.read_text(), factor))
    (folder / "prometheus.yaml").write_text(yaml.safe_dump({
        "global": {"scrape_interval": interval, "evaluation_interval": interval, "scrape_timeout": "1s"},
        "rule_files": ["rules.yaml"],
        "alerting": {"alertmanagers": [{"static_configs": [{"targets": [f"127.0.0.1:{alertmanager}"]}]}]},
        "scrape_configs": [{"job_name": "ppaas", "static_configs": [{"targets": [f"127.0.0.1:{target}"]}]}],
    }))  # fmt: skip
    (folder / "alertmanager.yaml").write_text(yaml.safe_dump({
        "route": {"receiver": "bench", "group_by": ["alertname"], "group_wait": "0s", "group_interval": "1s"},
        "receivers": [{"name": "bench", "webhook_configs": [{"url": f"http://127.0.0.1:{heard_at}/"}]}],
    }))  # fmt: skip


@contextlib.asynccontextmanager
async def monitoring(folder: Path, target: int, factor: float) -> AsyncIterator[Notifications]:
    """Watch a cloud that serves metrics at a port of this computer; yield the notifications.

    Raises
    ------
    Unavailable
        A program is not installed, or has exited.
    """
    for program in PROGRAMS:
        if shutil.which(program) is None:
            raise Unavailable(f"there is no {program}: install {' and '.join(PROGRAMS)}")
    prometheus, alertmanager, heard_at = free_ports(3)
    _configure(folder, target, factor, alertmanager, heard_at)
    heard = Notifications()
    manager = (
        PROGRAMS[1], f"--config.file={folder / 'alertmanager.yaml'}", f"--storage.path={folder / 'alerts'}",
        f"--web.listen-address=127.0.0.1:{alertmanager}", "--cluster.listen-address=",
    )  # fmt: skip
    scraper = (
        PROGRAMS[0], f"--config.file={folder / 'prometheus.yaml'}", f"--storage.tsdb.path={folder / 'series'}",
        f"--web.listen-address=127.0.0.1:{prometheus}", "--log.level=warn",
    )  # fmt: skip
    with receiver(heard_at, heard):
        async with (
            _program(*manager, log=folder / "alertmanager.log"),
            _program(*scraper, log=folder / "prometheus.log"),
        ):
            yield heard

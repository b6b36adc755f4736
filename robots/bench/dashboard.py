"""How fast the dashboard answers its first request."""

import http.client
from urllib.parse import urlsplit

from rich.progress import Progress

from ppaas.clock import monotonic
from robots.bench.figures import Figure, median_of
from robots.bench.target import Target

PART = "dashboard"
FETCHES, QUICK = 10, 2
LIMIT_MS = 1500.0


async def measure(target: Target, progress: Progress, quick: bool) -> list[Figure]:
    """Fetch the page anew, again and again; the first fetch counts too, for it is what a user sees first."""
    fetched = []
    for _ in progress.track(range(QUICK if quick else FETCHES), description="dashboard"):
        seconds, status = fetch(target.url)
        if status != http.client.OK:
            return []
        fetched.append(seconds)
    return [median_of(PART, "dashboard, its page", fetched, limit=LIMIT_MS, note="the HTML alone, without a browser")]


def fetch(url: str, path: str = "/dashboard") -> tuple[float, int]:
    """Return the seconds until a page is there, on a connection of its own, and its status."""
    began = monotonic()
    connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=30.0)
    try:
        connection.request("GET", path)
        response = connection.getresponse()
        response.read()
    finally:
        connection.close()
    return monotonic() - began, response.status

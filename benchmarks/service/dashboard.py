"""Load time of the dashboard: the HTML page alone, and the first paint in a browser if one is installed."""

import contextlib
import http.client
import importlib.util
import os
import shutil
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from rich.progress import Progress

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic

if TYPE_CHECKING:
    from playwright.async_api import Browser

PART = "dashboard"
RUNS, QUICK = 5, 1
LIMIT_MS = 1500.0
PATH = "/dashboard/"

FIRST_PAINT = """() => new Promise(tell => {
  const painted = list => list.filter(entry => entry.name === "first-contentful-paint").forEach(e => tell(e.startTime));
  new PerformanceObserver(list => painted(list.getEntries())).observe({type: "paint", buffered: true});
})"""
"""Script that returns the first contentful paint [ms since the begin of the navigation]."""


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Fetch the page, then measure its first paint in a browser with an empty cache."""
    runs = QUICK if quick else RUNS
    fetched = [fetch(target.url) for _ in progress.track(range(runs), description="dashboard, its page")]
    bare = median_of(PART, "its page, fetched", fetched, yardstick=True, note="the HTML alone")
    browser = installed_browser()
    if browser is None:
        return [bare]
    painted = await _paint(browser, target.url, runs)
    note = "first contentful paint in Chromium, nothing cached"
    return [median_of(PART, "dashboard, painted", painted, limit=LIMIT_MS, note=note), bare]


def installed_browser() -> str | None:
    """Return the path of Chromium; None if it, or what controls it, is not installed."""
    found = os.environ.get("PPAAS_CHROMIUM") or shutil.which("chromium")
    return None if importlib.util.find_spec("playwright") is None else found


@contextlib.asynccontextmanager
async def started_browser(executable: str) -> "AsyncIterator[Browser]":
    """Start Chromium."""
    from playwright.async_api import async_playwright  # noqa: PLC0415 - of the tests alone

    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            await browser.close()


def fetch(url: str, path: str = PATH) -> float:
    """Return the time to fetch a page over a new connection [s]."""
    began = monotonic()
    connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=30.0)
    try:
        connection.request("GET", path)
        connection.getresponse().read()
    finally:
        connection.close()
    return monotonic() - began


async def _paint(executable: str, url: str, runs: int) -> list[float]:
    painted = []
    async with started_browser(executable) as browser:
        for _ in range(runs + 1):
            context = await browser.new_context()
            page = await context.new_page()
            await page.goto(url + PATH)
            painted.append(await page.evaluate(FIRST_PAINT) / 1e3)
            await context.close()
    return painted[1:]  # the first includes the start of the browser

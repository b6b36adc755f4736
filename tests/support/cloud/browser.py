"""Headless Chromium for tests, controlled by Playwright."""

import os
import re
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from playwright.async_api import Browser, BrowserContext, ConsoleMessage, Page, async_playwright, expect

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from tests.support.waiting import PATIENCE

ARGUMENTS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
DESK, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
MARGIN_TOP, MARGIN_BOTTOM, MARGIN_SIDE = 76, 24, 24
"""Margins around a map that fits the page [px], as in `stage.js`."""


def chromium() -> str:
    """Return the path of the browser, or skip the test."""
    path = os.environ.get("PPAAS_CHROMIUM") or shutil.which("chromium")
    return path or pytest.skip("no browser: install Debian's chromium, or name one in PPAAS_CHROMIUM")


@asynccontextmanager
async def browsing(trusted_key: str = "") -> AsyncIterator[Browser]:
    """Start a browser.

    Parameters
    ----------
    trusted_key : str
        Base64 of the SHA-256 hash of a public key; certificates with this key are trusted. (With Playwright's
        ``ignore_https_errors`` each request of a page starts again, on a loaded computer until Chromium gives up.)
    """
    path = chromium()
    expect.set_options(timeout=1e3 * PATIENCE)
    arguments = [*ARGUMENTS, f"--ignore-certificate-errors-spki-list={trusted_key}"] if trusted_key else ARGUMENTS
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=path, args=arguments)
        try:
            yield browser
        finally:
            await browser.close()


@asynccontextmanager
async def looking(context: BrowserContext, expected: str = r"$^") -> AsyncIterator[Page]:
    """Open a page; fail if it logs errors or warnings other than the expected ones."""
    complaints: list[str] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and not re.search(expected, message.text):
            complaints.append(message.text)

    page = await context.new_page()
    page.set_default_timeout(1e3 * PATIENCE)  # of actions; `expect` has its own
    page.on("console", hear)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    try:
        yield page
        assert not complaints, complaints
    finally:
        await page.close()  # it would go on asking the cloud, and drawing, beside the next test


async def enter(page: Page, url: str, token: str) -> None:
    """Open the dashboard with a user already logged in."""
    # After a login ends, the page reloads and leaves a note; it must not be logged in again then.
    kept = f"sessionStorage.setItem('ppaas-token', '{token}')"
    await page.add_init_script(f"sessionStorage.getItem('ppaas-note') ?? {kept}")
    await page.goto(f"{url}/dashboard/")


class Eye:
    """Converts points of a map to pixels of the page, while the whole map is shown.

    Parameters
    ----------
    box : dict
        Bounding box of the canvas on the page [px].
    info : GridInfo
        Grid of the map.

    Attributes
    ----------
    corner : (float, float)
        A point outside every map [px].
    """

    def __init__(self, box: dict[str, float], info: GridInfo) -> None:
        height, width = info.shape
        edge = info.resolution
        corners = [info.origin @ Pose2D(x, y, 0.0) for x in (0, width * edge) for y in (0, height * edge)]
        left, right = min(c.x for c in corners), max(c.x for c in corners)
        bottom, top = min(c.y for c in corners), max(c.y for c in corners)
        wide, high = box["width"] - 2 * MARGIN_SIDE, box["height"] - MARGIN_TOP - MARGIN_BOTTOM
        self.scale = min(wide / (right - left), high / (top - bottom))
        self._middle = (left + right) / 2, (bottom + top) / 2
        self._at = box["x"] + box["width"] / 2, box["y"] + MARGIN_TOP + high / 2
        self.corner = box["x"] + box["width"] - 4, box["y"] + box["height"] - 4

    @classmethod
    async def on(cls, page: Page, info: GridInfo) -> "Eye":
        """Zoom to the whole map, and return its converter."""
        await page.locator("#zoom-fit").click()
        box = await page.locator("#map").bounding_box()
        assert box is not None
        return cls(dict(box), info)

    def see(self, pose: Pose2D) -> tuple[float, float]:
        """Return the pixel of a pose [px]."""
        dx, dy = pose.x - self._middle[0], pose.y - self._middle[1]
        return self._at[0] + dx * self.scale, self._at[1] - dy * self.scale

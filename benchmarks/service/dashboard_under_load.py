"""Measures the dashboard in a browser while robots drive, or takes screenshots of it.

``python -m benchmarks.service.dashboard_under_load [--robots N | --fleet N]
[--screenshots FOLDER [--traffic | --zones]]``.
The first paint is measured by the browser with an empty cache; the frame rate is measured for ten seconds with all
layers shown.
"""

import argparse
import asyncio
import contextlib
import itertools
import json
import re
import statistics
import sys
import tempfile
from collections.abc import AsyncIterator
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from playwright.async_api import Browser, Page, ViewportSize, expect

from benchmarks.service import console_fleet
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.zones.reading import zones_of
from tests.support.cloud.browser import Eye, browsing, enter
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.endpoints.zones import GRID, ZonesOfMap, serving_map
from tests.support.world.places import free_pose, reachable_pose

VISITS = 9
SECONDS = 10.0
DESK, PHONE = ViewportSize(width=1280, height=800), ViewportSize(width=390, height=844)
APART = 1.5
"""Least distance of robots at their start [m]."""

WAITED = re.compile(r"^([1-9]\d s|\d+ min)$")
"""The longest time for which robots waited in a cell, once it is at least 10 s."""

ONLINE = '#robots .presence[data-presence="online"]'


async def first_paint(browser: Browser, url: str) -> float:
    """Return the first contentful paint of a visit with an empty cache [ms]."""
    page = await browser.new_page(viewport=DESK)
    await page.goto(f"{url}/dashboard/")
    await page.get_by_role("button", name="Log in").wait_for()
    paint = await page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    await page.close()
    return float(paint)


async def frames(page: Page) -> tuple[float, float]:
    """Return the frame rate of the page [1/s], and the longest time between two frames [ms]."""
    script = """(ms) => new Promise((done) => {
        const times = [], began = performance.now();
        const look = (now) => { times.push(now); now - began < ms ? requestAnimationFrame(look) : done(times); };
        requestAnimationFrame(look);
    })"""
    gaps = [after - before for before, after in pairwise(await page.evaluate(script, SECONDS * 1000))]
    return 1000 / statistics.mean(gaps), max(gaps)


async def take_screenshots(browser: Browser, url: str, token: str, grid: GridMap, folder: Path) -> None:
    """Write screenshots of the dashboard on a desktop, and on a phone in dark mode."""
    views: list[tuple[str, ViewportSize, Literal["light", "dark"]]] = [
        ("dashboard", DESK, "light"),
        ("dashboard-phone", PHONE, "dark"),
    ]
    for name, size, scheme in views:
        context = await browser.new_context(viewport=size, color_scheme=scheme)
        page = await context.new_page()
        await enter(page, url, token)
        await expect(page.locator(ONLINE).first).to_be_attached()
        await page.evaluate("document.querySelector('#robots .robot').click()")
        await asyncio.sleep(3.0)  # until particles, scans and paths of all robots have arrived
        await Eye.on(page, grid.info)
        await page.screenshot(path=folder / f"{name}.png")
        await context.close()


async def take_traffic_screenshot(browser: Browser, url: str, token: str, grid: GridMap, folder: Path) -> None:
    """Write a screenshot of the dashboard once a robot waits, and robots have waited for some time."""
    context = await browser.new_context(viewport=DESK, color_scheme="light")
    page = await context.new_page()
    await enter(page, url, token)
    for layer in ("Laser scans", "Particles"):
        await page.get_by_role("switch", name=layer).uncheck()
    await expect(page.locator("#traffic-longest")).to_have_text(WAITED, timeout=240_000)
    await Eye.on(page, grid.info)
    await expect(page.locator("#traffic")).to_contain_text("Waits for", timeout=60_000)
    await page.locator("#panel-traffic").scroll_into_view_if_needed()
    await page.screenshot(path=folder / "traffic.png")
    await context.close()


def example_zones() -> ZonesOfMap:
    """Return a zone of each kind, and a lane; one of them is not in force."""
    rooms = {
        "dock": (0.6, 0.6, 5.4, 4.6), "crossing": (9.2, 6.2, 14.6, 9.8), "workshop": (15.0, 0.6, 23.4, 5.4),
        "store": (0.6, 11.0, 6.6, 15.4),
    }  # fmt: skip
    rules: dict[str, dict[str, Any]] = {
        "dock": {"kind": "keep_out", "times": [{"days": ["mon", "tue", "wed", "thu", "fri"], "from": "06:00"}]},
        "crossing": {"kind": "no_stop"},
        "workshop": {"kind": "speed_limit", "max_speed": 0.3},
        "store": {"kind": "capacity", "robots": 2, "times": [{"from": "22:00", "to": "06:00"}]},
    }
    corridor = {"type": "LineString", "coordinates": [[1.0, 7.4], [8.6, 7.4]]}
    features: list[dict[str, Any]] = [
        {"geometry": corridor, "properties": {"name": "corridor", "kind": "one_way", "width": 1.6}}
    ]
    for name, (left, bottom, right, top) in rooms.items():
        ring = [[left, bottom], [right, bottom], [right, top], [left, top], [left, bottom]]
        area = {"type": "Polygon", "coordinates": [ring]}
        features.append({"geometry": area, "properties": {"name": name, **rules[name]}})
    made = {"type": "FeatureCollection", "features": [{"type": "Feature", **each} for each in features]}
    return ZonesOfMap(zones_of(json.dumps({**made, "time_zone": "Europe/Berlin"})), {"corridor", *rooms} - {"store"})


async def take_zones_screenshot(folder: Path) -> None:
    """Write a screenshot of the dashboard with zones, one of which is being changed."""
    async with serving_map() as (url, token, _), browsing() as browser:
        page = await browser.new_page(viewport=DESK, color_scheme="light")
        await example_zones().answer(page)
        await enter(page, url, token)
        await page.get_by_role("button", name="workshop").click()
        await Eye.on(page, GRID.info)
        await page.locator("#panel-zones").scroll_into_view_if_needed()
        await page.screenshot(path=folder / "zones.png")


async def drive_on(drive: Drive, grid: GridMap, number: int) -> None:
    """Send a robot to one goal after another."""
    for seed in itertools.count(number, 100):
        pose = drive.world.robots[0].base.pose
        await drive.send(reachable_pose(grid, pose, seed, at_least=5.0))
        await drive.result(timeout=300.0)


async def in_traffic(stack: contextlib.AsyncExitStack, cloud: RunningCloud, grid: GridMap, robots: int) -> str:
    """Make some robots drive in the traffic of a map without end; return their owner's token."""
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    starts = standing_apart(grid, robots)
    drivers = await stack.enter_async_context(cancelled_at_the_end())
    token = ""
    for number, start in enumerate(starts):
        name = f"tb{number + 1}"
        token = await register_robot(rest, name, "office", start, {"traffic": {}})
        drive = await stack.enter_async_context(driving(cloud.url, token, name, grid, start, seed=number))
        drivers.append(asyncio.create_task(drive_on(drive, grid, number)))
    return token


def standing_apart(grid: GridMap, robots: int) -> list[Pose2D]:
    """Return free poses that are some distance apart."""
    starts: list[Pose2D] = []
    for seed in itertools.count(1):
        pose = free_pose(grid, seed)
        if all(pose.distance_to(other) > APART for other in starts):
            starts.append(pose)
        if len(starts) == robots:
            return starts
    raise AssertionError


@contextlib.asynccontextmanager
async def cancelled_at_the_end() -> AsyncIterator[list[asyncio.Task[None]]]:
    """Return a list of tasks, which are cancelled at the end."""
    tasks: list[asyncio.Task[None]] = []
    yield tasks
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def under_way(stack: contextlib.AsyncExitStack, cloud: RunningCloud, grid: GridMap, robots: int) -> str:
    """Make some robots drive to distant goals; return their owner's token."""
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    for number in range(robots):
        start, name = free_pose(grid, number + 1), f"turtlebot-{number + 1}"
        token = await register_robot(rest, name, "office", start)
        drive = await stack.enter_async_context(driving(cloud.url, token, name, grid, start, seed=number))
        await drive.send(reachable_pose(grid, start, number, at_least=9.0))
    return token


async def measure(folder: Path, robots: int, screenshots: Path | None, *, traffic: bool) -> None:
    """Start a cloud, a browser and robots; print the measurements, or write the screenshots."""
    grid = office(seed=1, width=24.0, height=16.0)
    async with contextlib.AsyncExitStack() as stack:
        cloud = stack.enter_context(running_cloud(folder))
        browser = await stack.enter_async_context(browsing())
        if screenshots and traffic:
            token = await in_traffic(stack, cloud, grid, robots)
            await take_traffic_screenshot(browser, cloud.url, token, grid, screenshots)
            return
        if screenshots:
            token = await under_way(stack, cloud, grid, robots)
            await take_screenshots(browser, cloud.url, token, grid, screenshots)
            return
        paints = [await first_paint(browser, cloud.url) for _ in range(VISITS)]
        say(f"first paint: {statistics.median(paints):.0f} ms, of {VISITS} {min(paints):.0f} to {max(paints):.0f} ms")
        token = await under_way(stack, cloud, grid, robots)
        page = await browser.new_page(viewport=DESK)
        await enter(page, cloud.url, token)
        await expect(page.locator(ONLINE)).to_have_count(robots, timeout=30_000)
        rate, longest = await frames(page)
        say(f"{robots} robots, all layers: {rate:.0f} frames a second, the longest gap {longest:.0f} ms")


def say(line: str) -> None:
    """Print a line."""
    sys.stdout.write(line + "\n")


def main() -> None:
    """Read the arguments and run."""
    parser = argparse.ArgumentParser(description="measure the dashboard in a browser, or take screenshots of it")
    parser.add_argument("--robots", type=int, default=10, help="number of driving robots (%(default)s)")
    parser.add_argument("--fleet", type=int, metavar="N", help="measure N made-up robots on one map instead")
    parser.add_argument(
        "--screenshots", type=Path, metavar="FOLDER", help="write screenshots there instead of measuring"
    )
    parser.add_argument(
        "--traffic", action="store_true", help="with --screenshots: robots take part in traffic, and only that is shown"
    )
    parser.add_argument("--zones", action="store_true", help="with --screenshots: only zones of a map are shown")
    arguments = parser.parse_args()
    if arguments.screenshots and arguments.zones:
        asyncio.run(take_zones_screenshot(arguments.screenshots))
        return
    if arguments.fleet:
        for name, load in asyncio.run(console_fleet.measure(arguments.fleet)):
            say(f"{name}: {load}")
        return
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(measure(Path(folder), arguments.robots, arguments.screenshots, traffic=arguments.traffic))


if __name__ == "__main__":
    main()

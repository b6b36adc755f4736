"""Driving by hand in the dashboard: the time from a key or a button in Chromium to the velocity at the robot."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING

from rich.progress import Progress

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from benchmarks.service.dashboard import installed_browser, started_browser
from benchmarks.service.plan_requests import echo
from benchmarks.service.teleop import COMMAND_LIMIT, FRAME, STOP_LIMIT, robot_in_hall
from ppaas.clock import epoch
from ppaas.errors import Unavailable
from ppaas.messages.geometry_msgs import Twist
from robots.client.cloud_url import path_of
from robots.client.robot_client import RobotClient
from robots.client.teleop import PERIOD, Hand, driving_by_hand

if TYPE_CHECKING:
    from playwright.async_api import Browser, Page

PART = "teleop-browser"
ROBOT = "bench-hand"
SAMPLES, QUICK = 60, 8
STOPS, QUICK_STOPS = 10, 2
WARM = 2
"""Number of samples that are not counted."""

MOST_LOCKS = 20
"""Number of samples that a busy computer may spoil, since the clone locks a driver whose commands are late."""

HELD = 0.217
"""Time for which a key is held [s]; no multiple of the periods of the page and the clone."""

PATIENCE = 2.0
"""Time limit of a sample [s]."""

TURN = 0.5
"""Turn of a robot that is stopped by the button [rad/s]."""

NOTE_TIMES = """
window.pressedAt = [];
for (const kind of ["keydown", "keyup", "click"]) {
  const note = (event) => event.repeat || window.pressedAt.push(performance.timeOrigin + event.timeStamp);
  window.addEventListener(kind, note, true);
}
"""
"""Script that notes when keys and buttons are pressed and released [ms since the epoch]."""

ECHOED = """([url, size]) => new Promise((done) => {
  const socket = new WebSocket(url);
  let began = performance.now();
  const send = () => { began = performance.now(); socket.send("x".repeat(size)); };
  socket.onopen = send;
  const times = [];
  socket.onmessage = () => {
    times.push(performance.now() - began);
    if (times.length < 60) setTimeout(send, 5); else { socket.close(); done(times); }
  };
})"""
"""Script that returns the times of exchanges of frames with an echo server [ms]."""


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Drive a simulated robot in a browser, if one is installed; measure keys, letting go, STOP, and an echo."""
    executable = installed_browser()
    if executable is None:
        return []
    arrivals = TimedCommands()
    async with robot_in_hall(target, ROBOT) as (client, operator), started_browser(executable) as browser:
        await client.subscribe("cmd_vel", Twist, arrivals.take)
        page = await _page(browser, target)
        commands, let_go = await _keys(page, arrivals, progress, QUICK if quick else SAMPLES)
        stops = await _stops(page, target, operator, arrivals, QUICK_STOPS if quick else STOPS)
        echoed = await _echoed(browser)
    note = "from the event in Chromium to the robot's socket"
    return [
        median_of(PART, "key to cmd_vel", commands, limit=COMMAND_LIMIT, note=note),
        median_of(PART, "key let go to cmd_vel 0", let_go, limit=STOP_LIMIT, note=note),
        median_of(PART, "button Stop to cmd_vel 0", stops, limit=STOP_LIMIT, note=f"{note}, while another drives"),
        median_of(PART, "echo of a frame", echoed, yardstick=True, note=f"{FRAME} bytes, from Chromium and back"),
    ]


class TimedCommands:
    """Velocities that arrive at the robot, with their times."""

    def __init__(self) -> None:
        self._awaited: Callable[[float], bool] = lambda _: False
        self._arrived: asyncio.Future[float] | None = None

    def take(self, twist: Twist) -> None:
        """Note a velocity."""
        if self._arrived is not None and not self._arrived.done() and self._awaited(twist.angular.z):
            self._arrived.set_result(epoch())

    def await_turn(self, awaited: Callable[[float], bool]) -> "asyncio.Future[float]":
        """Return the time at which a turn arrives for which a function returns true [s since the epoch]."""
        self._awaited, self._arrived = awaited, asyncio.get_running_loop().create_future()
        return self._arrived


async def _page(browser: "Browser", target: CloudUnderTest) -> "Page":
    """Open the card of the robot."""
    page = await browser.new_page(viewport={"width": 1280, "height": 800})
    await page.add_init_script(f"sessionStorage.setItem('ppaas-token', '{target.token}')")
    await page.add_init_script(NOTE_TIMES)
    await page.goto(f"{target.url}/dashboard/")
    await page.get_by_role("button", name=ROBOT).click()
    return page


async def _after(page: "Page", arrived: "asyncio.Future[float]") -> float | None:
    """Return the time from the last event in the page until the awaited velocity [s]; None if none has come."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PATIENCE):
            at = await arrived
            return at - float(await page.evaluate("window.pressedAt.at(-1)")) / 1e3
    return None


async def _keys(
    page: "Page", arrivals: TimedCommands, progress: Progress, count: int
) -> tuple[list[float], list[float]]:
    """Turn the robot to and fro by keys; return the times to velocities, and to zero [s]."""
    await page.get_by_role("button", name="Drive by hand").click()
    await page.locator(".teleop").get_by_role("status").get_by_text("Ready").wait_for()
    commands, let_go, locks = list[float](), list[float](), 0
    task = progress.add_task("teleop, in a browser", total=WARM + count)
    while len(let_go) < WARM + count:
        arrived = arrivals.await_turn(bool)
        key = "ad"[len(let_go) % 2]
        await page.keyboard.down(key)
        taken = await _after(page, arrived)
        await asyncio.sleep(HELD)
        stopped = arrivals.await_turn(lambda turn: turn == 0.0)
        await page.keyboard.up(key)
        stood = await _after(page, stopped)
        if taken is None or stood is None:
            locks += 1
            if locks > MOST_LOCKS:
                raise Unavailable("the computer is too busy: the clone locks the driver, whose commands are late")
            continue
        commands.append(taken)
        let_go.append(stood)
        progress.advance(task)
    await page.get_by_role("button", name="Stop driving").click()
    return commands[WARM:], let_go[WARM:]


async def _stops(
    page: "Page", target: CloudUnderTest, operator: RobotClient, arrivals: TimedCommands, count: int
) -> list[float]:
    """Stop a robot that another drives, by its button; return the times to zero [s]."""
    times: list[float] = []
    button = page.get_by_role("button", name="Stop", exact=True)
    async with driving_by_hand(operator) as hand:
        while len(times) < count:
            await hand.let_go()
            turning, arrived = asyncio.create_task(_turn(hand)), arrivals.await_turn(bool)
            await arrived
            stopped = arrivals.await_turn(lambda turn: turn == 0.0)
            await button.click()
            taken = await _after(page, stopped)
            turning.cancel()
            await asyncio.gather(turning, return_exceptions=True)
            times += [] if taken is None else [taken]
            releasing = asyncio.create_task(target.rest.post(path_of("robots", ROBOT, "release"), {}))
            while not await button.is_visible() or not releasing.done():  # the turn of a silent driver ends
                await hand.let_go()
                await asyncio.sleep(PERIOD)
            await releasing
    return times


async def _turn(hand: Hand) -> None:
    while True:
        await hand.drive(0.0, TURN)
        await asyncio.sleep(PERIOD)


async def _echoed(browser: "Browser") -> list[float]:
    """Return the times of exchanges between a page and an echo server [s]."""
    async with echo("websockets", FRAME) as server:
        page = await browser.new_page()
        times: list[float] = await page.evaluate(ECHOED, [f"ws://{server.address}", FRAME])
    return [each / 1e3 for each in times]

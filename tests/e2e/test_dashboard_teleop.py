"""Driving by hand in a real browser: keys, a window that loses the focus, a finger, and two operators."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from ppaas.geometry import Pose2D
from robots.client.rest import RestClient
from tests.support.cloud.browser import DESK, browsing, enter, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import patience, until
from tests.support.world.planar_world import walled_map

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

ROOM = walled_map(6.0, 4.0, [])
START = Pose2D(1.5, 2.0, 0.0)
ROBOT = "tb-pad"

PATIENT = {
    "teleop": {"command_timeout": 2.0, "view_timeout": 5.0, "lease_timeout": 20.0},
    "move_base": {"transform_tolerance": 5.0},
}
"""Limits for a computer that is busy with other tests, on which a key is held for long."""


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def scene(cloud: RunningCloud) -> AsyncIterator[tuple[Browser, str, str, Drive]]:
    """Return a browser, the address and token of a user, and the user's robot."""
    async with browsing() as browser:
        admin, rest = await cloud.admin(), RestClient(cloud.url)
        await admin.post("/v1/users", {"id": "paula", "password": ADMIN_PASSWORD})
        await rest.login("paula", ADMIN_PASSWORD)
        await publish_map(rest, "pad-room", ROOM)
        token = await register_robot(rest, ROBOT, "pad-room", START, PATIENT)
        async with driving(cloud.url, token, ROBOT, ROOM, START) as drive:
            await until(lambda: drive.poses)
            yield browser, cloud.url, token, drive


async def driver(page: Page, url: str, token: str) -> None:
    """Open the card of the robot, and ask to drive it."""
    await enter(page, url, token)
    await page.get_by_role("button", name=ROBOT).click()
    await page.get_by_role("button", name="Drive by hand").click()


def last(drive: Drive) -> tuple[float, float]:
    if not drive.commands:
        return 0.0, 0.0
    twist = drive.commands[-1][1]
    return twist.linear.x, twist.angular.z


async def hold(
    press: Callable[[], Awaitable[None]], release: Callable[[], Awaitable[None]], drives: Callable[[], bool]
) -> None:
    """Hold a control until the robot drives so; press it again if a busy computer has locked it."""
    async with patience(60.0):
        while not drives():
            await press()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(3.0):
                    await until(drives)
            if not drives():
                await release()


async def hold_key(page: Page, key: str, drives: Callable[[], bool]) -> None:
    """Hold a key until the robot drives so."""
    await hold(partial(page.keyboard.down, key), partial(page.keyboard.up, key), drives)


async def test_keys_and_fingers_drive_and_a_lost_focus_stops(scene: tuple[Browser, str, str, Drive]) -> None:
    browser, url, token, drive = scene
    context = await browser.new_context(viewport=DESK)
    async with looking(context) as page:
        await driver(page, url, token)
        card = page.locator(".teleop")
        await expect(card.get_by_role("status")).to_have_text("Ready")
        await hold_key(page, "w", lambda: last(drive) == (0.5, 0.0))
        await expect(card).to_contain_text("Round trip")
        await hold_key(page, "ArrowLeft", lambda: last(drive)[1] > 0.0)
        await page.keyboard.up("ArrowLeft")
        await page.keyboard.up("w")
        await until(lambda: last(drive) == (0.0, 0.0))
        await hold_key(page, "s", lambda: last(drive)[0] < 0.0)
        await page.evaluate("window.dispatchEvent(new Event('blur'))")
        await until(lambda: last(drive) == (0.0, 0.0))
        await page.keyboard.up("s")
        pad = await page.locator(".teleop-pad").bounding_box()
        assert pad is not None
        x, y = pad["x"] + pad["width"] / 2, pad["y"] + pad["height"] / 2

        async def drag() -> None:
            await page.mouse.move(x, y)
            await page.mouse.down()
            await page.mouse.move(x + 0.4 * pad["width"], y)

        await hold(drag, page.mouse.up, lambda: last(drive)[1] < -0.5)
        await page.mouse.up()
        await until(lambda: last(drive) == (0.0, 0.0))
        await card.get_by_role("button", name="Stop driving").click()
        await expect(card.get_by_role("button", name="Drive by hand")).to_be_visible()
    await context.close()


async def test_a_second_operator_takes_over_and_the_first_is_told(scene: tuple[Browser, str, str, Drive]) -> None:
    browser, url, token, drive = scene
    context = await browser.new_context(viewport=DESK)
    async with looking(context) as first, looking(context) as second:
        await driver(first, url, token)
        await expect(first.locator(".teleop").get_by_role("status")).to_have_text("Ready")
        await driver(second, url, token)
        said = second.locator(".teleop").get_by_role("status")
        await expect(said).to_have_text("paula drives")
        await second.get_by_role("button", name="Take over").click()
        await expect(said).to_have_text("Ready")
        await expect(first.locator(".teleop").get_by_role("status")).to_have_text("paula has taken over")
        await hold_key(second, "d", lambda: last(drive)[1] < 0.0)
        await second.close()
        await until(lambda: last(drive) == (0.0, 0.0))
    await context.close()


GAMEPAD = """
window.pads = [];
navigator.getGamepads = () => window.pads;
window.plug = (pressed, y) => {
  const buttons = Array.from({ length: 17 }, (_, at) => ({ pressed: at === 4 && pressed }));
  window.pads = [{ connected: true, axes: [0, y], buttons }];
};
window.unplug = () => {
  window.pads = [null];
  window.dispatchEvent(new Event("gamepaddisconnected"));
};
"""
"""A gamepad as the page sees it; Chromium has none without a device."""


async def test_a_gamepad_drives_and_the_robot_stops_when_it_is_unplugged(
    scene: tuple[Browser, str, str, Drive],
) -> None:
    browser, url, token, drive = scene
    context = await browser.new_context(viewport=DESK)
    await context.add_init_script(GAMEPAD)
    async with looking(context) as page:
        await driver(page, url, token)
        await expect(page.locator(".teleop").get_by_role("status")).to_have_text("Ready")

        def backwards() -> bool:
            return last(drive)[0] < -0.1

        await page.evaluate("window.plug(false, 1)")
        await hold(
            partial(page.evaluate, "window.plug(true, 1)"), partial(page.evaluate, "window.plug(false, 0)"), backwards
        )
        await page.evaluate("window.unplug()")
        await until(lambda: last(drive) == (0.0, 0.0))
        await page.get_by_role("button", name="Give back").click()
        await expect(page.get_by_role("button", name="Drive by hand")).to_be_visible()
        await until(lambda: last(drive) == (0.0, 0.0))
    await context.close()

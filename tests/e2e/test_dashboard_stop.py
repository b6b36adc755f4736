"""STOP ALL and the stop of a robot in the dashboard, on a desk and on a phone: one press stops, a release asks."""

from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from tests.support.cloud.browser import DESK, PHONE, enter, looking
from tests.support.endpoints.fleet import RobotSockets, serving_fleet

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]


@pytest_asyncio.fixture(loop_scope="module", params=[DESK, PHONE], ids=["desk", "phone"])
async def page(request: pytest.FixtureRequest, browser: Browser) -> AsyncIterator[Page]:
    """Return a page of a fleet of two."""
    sockets = RobotSockets()
    async with serving_fleet(2) as (url, token, _), sockets.beating():
        context = await browser.new_context(viewport=request.param)
        async with looking(context, "503") as opened:
            await sockets.answer(opened)
            await enter(opened, url, token)
            await expect(opened.locator("#robots > li")).to_have_count(2)
            yield opened


async def test_one_press_of_a_key_stops_all_and_a_release_asks(page: Page) -> None:
    stop_all, stopped = page.get_by_role("button", name="STOP ALL"), page.locator("#stopped")
    await expect(stop_all).to_be_in_viewport(ratio=1.0)
    await stop_all.focus()
    await page.keyboard.press("Enter")
    await expect(stopped).to_contain_text("All robots are stopped by ann since")
    await expect(stop_all).to_be_in_viewport(ratio=1.0)
    await stopped.get_by_role("button", name="Release…").click()
    await page.get_by_role("button", name="Stay stopped").click()
    await expect(stopped).to_be_visible()
    await stopped.get_by_role("button", name="Release…").click()
    await page.get_by_role("dialog").get_by_role("button", name="Release", exact=True).click()
    await expect(stopped).to_be_hidden()


async def test_a_robot_is_stopped_and_released_by_its_card(page: Page) -> None:
    if not await page.locator("#panel-robots").is_visible():
        await page.locator(".tab[data-panel=robots]").click()
    await page.locator("#robots .robot").first.click()
    card = page.locator("#robot-card")
    await card.get_by_role("button", name="Stop", exact=True).click()
    await expect(page.locator("#stopped")).to_contain_text("tb0 is stopped by ann since")
    await card.get_by_role("button", name="Release…").click()
    await page.get_by_role("dialog").get_by_role("button", name="Release", exact=True).click()
    await expect(card.get_by_role("button", name="Stop", exact=True)).to_be_visible()


async def test_a_stop_that_is_refused_is_said_loudly(page: Page) -> None:
    async def refuse(route: Any) -> None:
        await route.fulfill(status=503, json={"detail": "no master answers"})

    await page.route("**/v1/stop", refuse)
    await page.get_by_role("button", name="STOP ALL").click()
    await expect(page.locator("#toasts")).to_contain_text("NOT STOPPED: no master answers")

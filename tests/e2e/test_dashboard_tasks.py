"""Places of tasks, picked on the map of the dashboard by mouse, keyboard and touch."""

from collections.abc import AsyncIterator

import pytest
from playwright.async_api import Page, expect

from ppaas.geometry import Pose2D
from tests.support.cloud.browser import DESK, PHONE, Eye, browsing, enter, looking
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.endpoints.zones import GRID

pytestmark = pytest.mark.journey


@pytest.fixture(params=[DESK, PHONE], ids=["desk", "phone"])
async def page(request: pytest.FixtureRequest) -> AsyncIterator[Page]:
    """Open the page of tasks of a fleet, with the form of a new task."""
    sockets = RobotSockets()
    async with serving_fleet(2) as (url, token, _), browsing() as browser:
        context = await browser.new_context(viewport=request.param, has_touch=request.param == PHONE)
        async with looking(context) as opened:
            await sockets.answer(opened)
            await enter(opened, url, token)
            await expect(opened.locator("#robots > li")).to_have_count(2)
            await opened.get_by_role("link", name="Tasks").click()
            await opened.get_by_text("Add a task").click()
            yield opened


async def test_places_of_a_task_are_picked_on_the_map(page: Page) -> None:
    written = page.get_by_role("textbox", name="Places")
    await page.get_by_label("What").select_option("Pick at one place, drop at another")
    await page.get_by_role("button", name="Pick on the map").click()
    await expect(page.locator("#hint")).to_contain_text("Click each place")
    eye = await Eye.on(page, GRID.info)
    for number, place in enumerate(((2.0, 3.0), (9.0, 8.0)), 1):
        await expect(page.locator("#picking-count")).to_have_text(f"{number - 1} places" if number == 1 else "1 place")
        await page.mouse.click(*eye.see(Pose2D(*place, 0.0)))
    await expect(page.locator("#page h2")).to_have_text("Tasks")
    lines = [list(map(float, line.split())) for line in (await written.input_value()).splitlines()]
    assert lines == [pytest.approx([2.0, 3.0], abs=0.2), pytest.approx([9.0, 8.0], abs=0.2)]
    await expect(page.locator("#picking")).to_be_hidden()
    await page.get_by_role("button", name="Add", exact=True).click()
    task = page.get_by_role("region", name="Waiting").get_by_role("listitem")
    await expect(task).to_contain_text("Pick at")


async def test_picking_is_ended_undone_and_cancelled_by_keyboard_and_by_leaving(page: Page) -> None:
    written = page.get_by_role("textbox", name="Places")
    await page.get_by_label("What").select_option("Patrol along places")
    await written.fill("1 1")
    pick, canvas = page.get_by_role("button", name="Pick on the map"), page.locator("#map")
    await pick.click()
    await expect(page.locator("#picking-end")).to_be_disabled()
    for key in (" ", "ArrowLeft", " ", " ", "Backspace", "Enter"):
        await canvas.press(key)
    await expect(page.locator("#page h2")).to_have_text("Tasks")
    assert len((await written.input_value()).splitlines()) == 3
    await pick.click()
    await canvas.press(" ")
    await page.get_by_role("button", name="Cancel", exact=True).click()
    await expect(page.locator("#page h2")).to_have_text("Tasks")
    await pick.click()
    await canvas.press(" ")
    await page.get_by_role("link", name="Plans").click()
    await expect(page.locator("#picking")).to_be_hidden()
    await page.get_by_role("link", name="Tasks").click()
    assert len((await written.input_value()).splitlines()) == 3
    await page.get_by_role("link", name="Map", exact=True).click()
    await expect(page.locator("#hint")).to_be_empty()

"""The table of all robots, with hundreds of them: sorted, searched, and drawn as far as it is visible."""

from collections.abc import AsyncIterator

import pytest
from playwright.async_api import Page, expect

from tests.support.cloud.browser import DESK, browsing, enter, looking
from tests.support.endpoints.fleet import RobotSockets, serving_fleet

pytestmark = pytest.mark.journey

ROBOTS = 500
ALL = ROBOTS + 1
CONNECTED, FAILED = 5, 3
VISIBLE = 50
"""Most rows that the page draws on a desk."""


@pytest.fixture
async def table() -> AsyncIterator[Page]:
    """Return a page that shows the table of a fleet, of which the first robots are connected."""
    sockets, served, started = (
        RobotSockets(),
        serving_fleet(ROBOTS, lambda number: number < CONNECTED, ("mower",)),
        browsing(),
    )
    async with served as (url, token, _), started as browser, sockets.beating():
        context = await browser.new_context(viewport=DESK)
        async with looking(context) as page:
            await sockets.answer(page)
            await enter(page, url, token)
            await expect(page.locator("#robots > li")).to_have_count(ROBOTS)
            await expect(page.locator("#robots .robot").nth(FAILED)).to_contain_text("No pose of it comes")
            sockets.place(f"tb{FAILED}", 3.0, 5.0)
            sockets.status(f"tb{FAILED}", 4, "There is no way to the goal")
            await page.get_by_role("button", name="Fleet").click()
            await expect(page.locator("#fleet-count")).to_have_text(f"{ALL} robots")
            yield page


async def test_hundreds_of_robots_are_listed_and_only_visible_ones_drawn(table: Page) -> None:
    rows = table.locator("#fleet tbody tr")
    await expect(rows.first).to_contain_text("mower")
    assert await rows.count() <= VISIBLE
    await expect(table.locator("#fleet table")).to_have_attribute("aria-rowcount", str(ALL + 1))
    await table.locator("#fleet-rows").evaluate("one => one.scrollTop = one.scrollHeight")
    await expect(rows.last).to_contain_text(f"tb{ROBOTS - 1}")
    await expect(rows.last).to_have_attribute("aria-rowindex", str(ALL + 1))
    await expect(rows.last).to_be_in_viewport()
    assert await rows.count() <= VISIBLE


async def test_robots_are_sorted_by_each_column(table: Page) -> None:
    first, rows = table.locator("#fleet tbody tr").first, table.locator("#fleet thead th")
    for title, rising, falling in (("Robot", "tb499", "mower"), ("Error", "tb3", "tb3"), ("Machine", "m1", "m2")):
        await table.locator("#fleet thead").get_by_role("button", name=title).click()
        await expect(first).to_contain_text(rising)
        await table.locator("#fleet thead").get_by_role("button", name=title).click()
        await expect(first).to_contain_text(falling)
    await expect(rows.last).to_have_attribute("aria-sort", "descending")
    await expect(rows.first).to_have_attribute("aria-sort", "none")


async def test_a_robot_is_searched_and_its_card_opened_by_keyboard(table: Page) -> None:
    rows = table.locator("#fleet tbody tr")
    await table.get_by_role("searchbox", name="Search robots").fill("m2 no way")
    await expect(rows).to_have_count(1)
    await expect(table.locator("#fleet-count")).to_have_text(f"1 of {ALL} robots")
    await expect(rows).to_contain_text("There is no way to the goal")
    await rows.get_by_role("button", name="tb3").press("Enter")
    await expect(table.locator("#fleet")).to_be_hidden()
    await expect(table.locator("#robot-card .name")).to_have_text("tb3")


async def test_a_search_without_result_shows_none(table: Page) -> None:
    await table.get_by_role("searchbox", name="Search robots").fill("<b>nobody")
    await expect(table.locator("#fleet tbody tr")).to_have_count(0)
    await expect(table.locator("#fleet-count")).to_have_text(f"0 of {ALL} robots")
    await table.get_by_role("button", name="Close").click()
    await expect(table.locator("#fleet")).to_be_hidden()


async def test_a_robot_of_another_map_is_shown_on_that_map(table: Page) -> None:
    await expect(table.locator("#map-choice")).to_have_value("office")
    await table.get_by_role("button", name="mower").click()
    await expect(table.locator("#map-choice")).to_have_value("yard")
    await expect(table.locator("#robots > li")).to_have_count(1)
    await expect(table.locator("#robot-card .name")).to_have_text("mower")

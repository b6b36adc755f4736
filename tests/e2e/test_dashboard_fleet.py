"""The table of all robots, with hundreds of them: sorted, searched, and drawn as far as it is visible."""

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from engine.master.places import robot_key
from engine.protocols.robot_link import ContainerBeat
from engine.specs.robot_report import StateReport
from ppaas.messages.actionlib_msgs import Status
from tests.support.cloud.browser import DESK, enter, looking
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.waiting import until

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

ROBOTS = 500
ALL = ROBOTS + 1
CONNECTED, FAILED = 5, 3
MANY = 80
"""Robots on one map, more than have sockets."""
VISIBLE = 50
"""Most rows that the page draws on a desk."""


@pytest_asyncio.fixture(loop_scope="module")
async def table(browser: Browser) -> AsyncIterator[Page]:
    """Return a page that shows the table of a fleet, of which the first robots are connected."""
    sockets, served = RobotSockets(), serving_fleet(ROBOTS, lambda number: number < CONNECTED, ("mower",))
    async with served as (url, token, cloud), sockets.beating():
        context = await browser.new_context(viewport=DESK)
        async with looking(context) as page:
            await sockets.answer(page)
            await enter(page, url, token)
            await expect(page.locator("#robots > li")).to_have_count(ROBOTS)
            await expect(page.locator("#robots .robot").nth(FAILED)).to_contain_text("No pose of it comes")
            failed = StateReport(goal=Status.ABORTED, goal_text="There is no way to the goal", battery=0.4)
            cloud.places[robot_key("ann", f"tb{FAILED}")].take(ContainerBeat(busy=False, robot=True, report=failed))
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
    for title, rising, falling in (
        ("Robot", "tb499", "mower"),
        ("Error", "tb3", "tb3"),
        ("Battery", "tb3", "tb3"),
        ("Machine", "m1", "m2"),
    ):
        await table.locator("#fleet thead").get_by_role("button", name=title).click()
        await expect(first).to_contain_text(rising)
        await table.locator("#fleet thead").get_by_role("button", name=title).click()
        await expect(first).to_contain_text(falling)
    await expect(rows.filter(has_text="Machine")).to_have_attribute("aria-sort", "descending")
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


async def test_of_many_robots_on_a_map_few_have_sockets_and_all_are_placed(browser: Browser) -> None:
    sockets, served = RobotSockets(), serving_fleet(MANY)
    async with served as (url, token, _), sockets.beating():
        context = await browser.new_context(viewport=DESK)
        async with looking(context) as page:
            await sockets.answer(page)
            await enter(page, url, token)
            robots = page.locator("#robots .presence")
            await expect(robots).to_have_count(MANY)
            await until(lambda: "tb0" in sockets.open)
            names = [f"tb{number}" for number in range(1, MANY)]
            poses = [{"position": {"x": 3, "y": 5, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}] * (
                MANY - 1
            )
            sockets.publish("tb0", "robots", {"names": names, "poses": poses})
            await expect(robots.nth(MANY - 1)).to_have_text("online")
            assert sockets.open.keys() == {"tb0"}
            await page.get_by_role("button", name="tb7", exact=False).first.click()
            await until(lambda: "tb7" in sockets.open)
            assert sockets.open.keys() == {"tb0", "tb7"}
        await context.close()

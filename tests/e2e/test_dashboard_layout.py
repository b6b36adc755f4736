"""Where the parts of the dashboard are, on a desk and on a phone, with a fleet whose robots the test moves."""

import re
from collections.abc import AsyncIterator
from dataclasses import dataclass

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, Page, expect

from tests.e2e.test_dashboard_zones import zones
from tests.support.cloud.browser import DESK, PHONE, enter, looking
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.endpoints.zones import ZonesOfMap

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

WIDE = {"width": 1440, "height": 900}
ROBOTS = 12
LOST = r"^Failed to load resource: net::ERR_INTERNET_DISCONNECTED"


@dataclass
class Fleet:
    """A cloud with a fleet, and a browser to look at it."""

    url: str
    token: str
    cloud: FakeCloud
    browser: Browser
    sockets: RobotSockets

    async def enter(self, page: Page) -> None:
        """Open the dashboard on a page, whose robots the test answers for."""
        await self.sockets.answer(page)
        await enter(page, self.url, self.token)
        await expect(page.locator("#robots > li")).to_have_count(ROBOTS)


@pytest_asyncio.fixture(loop_scope="module")
async def fleet(browser: Browser) -> AsyncIterator[Fleet]:
    """Return a fleet of which all robots but the last two are connected."""
    served, sockets = serving_fleet(ROBOTS, lambda number: number < ROBOTS - 2), RobotSockets()
    async with served as (url, token, cloud), sockets.beating():
        yield Fleet(url, token, cloud, browser, sockets)


async def test_robots_stay_listed_beside_the_card_of_one_on_a_desk(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    async with looking(context) as page:
        await fleet.enter(page)
        await page.locator("#robots .robot").first.click()
        await expect(page.locator("#robot-card")).to_be_visible()
        panel = await box(page.locator("#panel-robots"))
        items = [await box(item) for item in await page.locator("#robots > li").all()]
        shown = [item for item in items if item["y"] + item["height"] <= panel["y"] + panel["height"]]
        assert len(shown) >= 8, f"{len(shown)} robots are visible"
        for part in ("#panel-layers", "#panel-load", "#robot-card"):
            assert (await box(page.locator(part)))["height"] >= 150, part
            assert not overlap(panel, await box(page.locator(part))), part
    await context.close()


async def test_the_card_takes_the_place_of_the_list_on_a_phone(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=PHONE, has_touch=True)
    async with looking(context) as page:
        await fleet.enter(page)
        await page.get_by_role("button", name="Robots", exact=True).tap()
        await page.get_by_role("button", name="tb3").tap()
        await expect(page.locator("#panel-robots")).to_be_hidden()
        card, stage = await box(page.locator("#robot-card")), await box(page.locator(".stage"))
        assert card["height"] >= 200 and card["y"] + card["height"] <= PHONE["height"]
        assert stage["height"] >= 200 and not overlap(card, stage)
        await expect(page.get_by_role("combobox", name="Map", exact=True)).to_have_value("office")
        await page.get_by_role("button", name="Robots", exact=True).tap()
        await expect(page.locator("#panel-robots")).to_be_visible()
    await context.close()


async def test_no_tool_is_active_while_a_zone_is_drawn(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    async with looking(context) as page:
        await ZonesOfMap().answer(page)
        await fleet.enter(page)
        await page.locator("#robots .robot").first.click()
        drive = page.locator("#tool-drive")
        await expect(drive).to_have_attribute("aria-pressed", "true")
        await page.get_by_role("button", name="Add zone").click()
        await expect(page.locator(".tool[aria-pressed=true]")).to_have_count(0)
        await expect(drive).to_be_disabled()
        await expect(page.locator("#hint")).to_have_text("Click on the map to draw; Escape cancels")
        await page.locator("#map").press("Escape")
        await expect(drive).to_have_attribute("aria-pressed", "true")
        await expect(drive).to_be_enabled()
    await context.close()


async def test_a_robot_without_signal_is_not_said_to_be_well(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    well = {"connected": True, "findings": [], "topics": []}
    await context.route("**/diagnosis?*", lambda route: route.fulfill(json=well))
    async with looking(context) as page:
        await fleet.enter(page)
        card = page.locator("#robot-card")
        await page.locator("#robots .robot").first.click()
        await card.get_by_text("What is wrong?").click()
        await expect(card.locator(".presence")).to_have_text("no signal")
        await expect(card.locator(".doing")).to_have_text("No pose of it comes")
        await expect(card).to_contain_text("finds nothing wrong, but no pose of the robot comes to this page")
    await context.close()


async def test_an_error_of_a_robot_is_shown_in_full(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    async with looking(context) as page:
        await fleet.enter(page)
        text = "There is no way to the goal, for a box is in the corridor. " * 8
        await expect(page.locator("#robots .robot").first).to_contain_text("No pose of it comes")
        fleet.sockets.place("tb0", 3.0, 5.0)
        fleet.sockets.status("tb0", 4, text)
        await page.locator("#robots .robot").first.click()
        doing = page.locator("#robot-card .doing")
        await expect(doing).to_have_text(text)
        assert await doing.evaluate("one => one.scrollHeight <= one.clientHeight"), "it is cut"
    await context.close()


async def test_loads_are_marked_as_old_while_the_cloud_does_not_answer(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    async with looking(context, LOST) as page:
        await fleet.enter(page)
        note, load = page.locator("#load-note"), page.locator("#machines .load").first
        await expect(load).to_have_css("border-style", "solid")
        await expect(note).to_be_hidden()
        await context.set_offline(True)
        await expect(note).to_have_text(re.compile(r"^As of .*: the cloud does not answer$"))
        await expect(load).to_have_css("border-style", "dashed")
        await context.set_offline(False)
        await expect(note).to_be_hidden()
        await expect(load).to_have_css("border-style", "solid")
    await context.close()


async def test_the_bar_of_a_small_desk_shows_all_pages(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=DESK)
    async with looking(context) as page:
        await fleet.enter(page)
        assert await page.locator("#pages").evaluate("one => one.scrollWidth <= one.clientWidth"), "pages are cut"
        logout = await box(page.get_by_role("button", name="Log out"))
        assert logout["height"] <= 46 and logout["x"] + logout["width"] <= DESK["width"]
    await context.close()


async def test_the_bar_of_a_phone_has_room_for_the_name_of_the_map(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=PHONE, has_touch=True)
    async with looking(context) as page:
        await fleet.enter(page)
        assert (await box(page.locator("#map-choice")))["width"] >= 110
        for name in ("STOP ALL", "Fleet", "Log out"):
            button = await box(page.get_by_role("button", name=name, exact=True))
            assert button["width"] >= 40 and button["height"] >= 44, name
            assert button["x"] + button["width"] <= PHONE["width"], name
    await context.close()


async def test_no_message_hides_who_has_stopped_the_robots_on_a_phone(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=PHONE, has_touch=True)
    async with looking(context) as page:
        await fleet.enter(page)
        await page.get_by_role("button", name="STOP ALL").tap()
        await expect(page.locator("#stopped")).to_contain_text("stopped by ann")
        assert not overlap(await box(page.locator("#stopped")), await box(page.locator(".toast").last))
    await context.close()


async def test_the_map_does_not_wait_for_a_goal_of_a_robot_that_is_not_connected(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    async with looking(context) as page:
        await fleet.enter(page)
        for robot, tool in (("tb0", "drive"), (f"tb{ROBOTS - 1}", "look")):
            await page.locator("#robots").get_by_role("button", name=robot).first.click()
            await expect(page.locator(f"#tool-{tool}")).to_have_attribute("aria-pressed", "true")
    await context.close()


async def test_what_is_wrong_with_a_robot_is_seen_on_a_phone(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=PHONE, has_touch=True)
    async with looking(context) as page:
        await fleet.enter(page)
        await page.get_by_role("button", name="Robots", exact=True).tap()
        await page.locator("#robots .robot").last.tap()
        await page.get_by_text("What is wrong?").tap()
        finding = page.locator("#robot-card .finding").first
        await expect(finding).to_contain_text("is not connected")
        inner, outer = await box(finding), await box(page.locator("#robot-card .diagnosis"))
        assert outer["y"] + outer["height"] >= inner["y"] + inner["height"]
    await context.close()


async def test_a_change_that_waits_leaves_room_for_the_form_of_a_zone(fleet: Fleet) -> None:
    context = await fleet.browser.new_context(viewport=WIDE)
    review = {
        "number": 4, "version": "0" * 64, "author": "ann", "message": "a pallet", "state": "waiting", "outdated": False,
        "occupied": 3, "free": 0, "known": 0, "unknown": 0, "rectangles": [],
    }  # fmt: skip
    waiting = {"items": [review], "next": None}
    await context.route("**/v1/maps/office/reviews?*", lambda route: route.fulfill(json=waiting))
    async with looking(context) as page:
        await ZonesOfMap(zones({"name": "Dock", "kind": "keep_out"}), ["Dock"]).answer(page)
        await fleet.enter(page)
        await expect(page.locator("#reviews")).to_contain_text("a pallet")
        await page.locator("#zones .robot").click()
        form = page.locator(".zone-form")
        await form.scroll_into_view_if_needed()
        shown, panel = await box(form), await box(page.locator("#panel-robots"))
        seen = min(shown["y"] + shown["height"], panel["y"] + panel["height"]) - max(shown["y"], panel["y"])
        assert seen >= min(shown["height"], 400), f"{seen} px of the form are visible"
    await context.close()


async def box(part: Locator) -> dict[str, float]:
    """Return where a part of the page is [px]."""
    found = await part.bounding_box()
    assert found is not None
    return dict(found)


def overlap(one: dict[str, float], other: dict[str, float]) -> bool:
    """Return whether two boxes share more than an edge."""
    return all(
        one[at] + one[size] > other[at] + 1 and other[at] + other[size] > one[at] + 1
        for at, size in (("x", "width"), ("y", "height"))
    )

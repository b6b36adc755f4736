"""Zones of a map in the dashboard, in a real browser, with answers of the cloud that the test sets."""

import json
import re
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any

import msgspec
import pytest
import pytest_asyncio
from playwright.async_api import Browser, BrowserContext, Locator, Page, expect

from ppaas.geometry import Pose2D
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import ZoneSet
from tests.support.cloud.browser import DESK, PHONE, Eye, enter, looking
from tests.support.endpoints.zones import GRID, ZonesOfMap, serving_map

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

SQUARE = [[4, 4], [8, 4], [8, 8], [4, 8], [4, 4]]
EXPECTED = r"willReadFrequently|^Failed to load resource: .* 4(00|09|22)"

RED_PIXELS = """(wanted) => {
    const map = document.getElementById("map");
    const { data } = map.getContext("2d").getImageData(0, 0, map.width, map.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] - Math.max(data[i + 1], data[i + 2]) > 100) count += 1;
    return (count > 100) === wanted;
}"""
"""Check that the outline of a keep-out zone is on the map, or that it is not."""

RED_AT = """([x, y, wanted]) => {
    const map = document.getElementById("map");
    const box = map.getBoundingClientRect();
    const scale = map.width / box.width;
    const { data } = map.getContext("2d").getImageData((x - box.left) * scale - 6, (y - box.top) * scale - 6, 12, 12);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] - Math.max(data[i + 1], data[i + 2]) > 100) count += 1;
    return (count > 8) === wanted;
}"""
"""Check that there is a red mark at a place of the screen, or that there is none."""


def zones(*rules: dict[str, Any], **more: Any) -> ZoneSet:
    """Return zones with one rule each, which stand side by side."""
    areas = ([[[x + 10 * number, y] for x, y in SQUARE]] for number in range(len(rules)))
    features = [
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": area}, "properties": rule}
        for rule, area in zip(rules, areas, strict=True)
    ]
    return zones_of(json.dumps({"type": "FeatureCollection", "features": features, **more}))


async def desk(browser: Browser) -> BrowserContext:
    return await browser.new_context(viewport=DESK)


def rules_of(found: ZoneSet) -> list[Any]:
    return [msgspec.to_builtins(zone.rule) for zone in found.zones]


@dataclass
class Shown:
    """A page that shows the map, and the zones that it gets."""

    page: Page
    given: ZonesOfMap
    eye: Eye

    @property
    def group(self) -> Locator:
        """The panel of zones."""
        return self.page.get_by_role("group", name="Zones")

    async def click(self, *places: tuple[float, float]) -> None:
        """Click places of the map [m]."""
        for x, y in places:
            await self.page.mouse.click(*self.eye.see(Pose2D(x, y, 0.0)))

    async def add(self, kind: str) -> None:
        """Begin to draw a zone."""
        await self.group.get_by_label("New zone").select_option(label=kind)
        await self.group.get_by_role("button", name="Add zone").click()

    async def save(self) -> None:
        """Save the zones, and wait for the answer."""
        await self.group.get_by_role("button", name="Save", exact=True).click()
        await expect(self.page.locator(".toast").last).to_contain_text("The zones are saved")


@pytest_asyncio.fixture(loop_scope="module")
async def shown(browser: Browser) -> AsyncIterator[Shown]:
    """Return a page of ann, whose map has a zone that is in force and one that is not."""
    given = ZonesOfMap(
        zones({"name": "<b>dock", "kind": "keep_out"}, {"name": "aisle", "kind": "no_stop"}), ["<b>dock"]
    )
    async with serving_map() as (url, ann, _), looking(await desk(browser), EXPECTED) as page:
        await given.answer(page)
        await enter(page, url, ann)
        await expect(page.locator("#zones > li")).to_have_count(2)
        yield Shown(page, given, await Eye.on(page, GRID.info))


async def test_zones_are_listed_and_drawn_until_they_are_hidden(shown: Shown) -> None:
    page, first, second = shown.page, shown.page.locator("#zones > li").first, shown.page.locator("#zones > li").last
    await expect(first).to_contain_text("<b>dockin forceKeep out")
    await expect(second).to_contain_text("aislenot in forceNo stopping")
    assert await page.locator("#zones b").count() == 0
    await page.wait_for_function(RED_PIXELS, arg=True)
    await page.get_by_role("switch", name="Zones").uncheck()
    await page.wait_for_function(RED_PIXELS, arg=False)
    await page.get_by_role("switch", name="Zones").check()
    await page.wait_for_function(RED_PIXELS, arg=True)


async def test_a_zone_is_drawn_changed_and_saved(shown: Shown) -> None:
    page = shown.page
    await shown.add("Speed limit")
    await shown.click((12, 10), (16, 10), (16, 14))
    await page.keyboard.press("Enter")
    await expect(page.locator("#zones > li").last).to_contain_text("Speed limit 1not savedSpeed limit 0.5 m/s")
    form = shown.group.get_by_role("form", name="Zone Speed limit 1")
    await form.get_by_label("Highest speed").fill("0.3")
    await form.get_by_label("Name").fill("ramp")
    await form.get_by_role("button", name="Add hours").click()
    for day in ("sat", "sun"):
        await form.get_by_label(day).uncheck()
    await expect(page.locator("#zones > li").last).to_contain_text("Speed limit 0.3 m/s; mon to fri 08:00 to 18:00")
    await shown.group.get_by_label("Time zone").fill("Europe/Berlin")
    await shown.save()
    await expect(page.locator("#zones > li").last).to_contain_text("rampin force")
    assert shown.given.asked[-1]["content-type"] == "application/geo+json"
    assert shown.given.asked[-1]["if-match"] == '"v1"'
    saved = shown.given.zones
    times = [{"days": ["mon", "tue", "wed", "thu", "fri"], "from": "08:00", "to": "18:00"}]
    assert rules_of(saved)[2] == {"name": "ramp", "kind": "speed_limit", "max_speed": 0.3, "times": times}
    assert saved.time_zone == "Europe/Berlin"
    ring = saved.zones[2].geometry.coordinates[0]  # type: ignore[index]
    assert [
        [pytest.approx(x, abs=0.05), pytest.approx(y, abs=0.05)] for x, y in ((12, 10), (16, 10), (16, 14), (12, 10))
    ] == ring
    await expect(shown.group.get_by_role("button", name="Save", exact=True)).to_be_hidden()


async def test_a_one_way_line_ends_with_a_double_click(shown: Shown) -> None:
    await shown.add("One way, a line")
    await expect(shown.group).to_contain_text("2 more are needed")
    await shown.click((4, 10), (12, 10))
    await shown.page.mouse.dblclick(*shown.eye.see(Pose2D(12, 14, 0.0)))
    await shown.group.get_by_label("Width [m]").fill("1.5")
    await shown.group.get_by_role("switch", name="Crossing is forbidden too").check()
    await shown.save()
    line = shown.given.zones.zones[2]
    assert msgspec.to_builtins(line.rule) == {"name": "One way 1", "kind": "one_way", "width": 1.5, "strict": True}
    assert len(line.geometry.coordinates) == 3


async def test_a_lane_is_drawn_and_leads_one_way_if_wanted(shown: Shown) -> None:
    entry, form = shown.page.locator("#zones > li").last, shown.group.get_by_role("form", name="Zone Lane 1")
    await shown.add("Lane")
    await shown.click((4, 10), (12, 10), (12, 14))
    await shown.page.keyboard.press("Enter")
    await expect(entry).to_contain_text("Lane 1not savedLane")
    await expect(form.get_by_label("Width")).to_have_count(0)
    await expect(form.get_by_role("button", name="Add hours")).to_have_count(0)
    await form.get_by_role("switch", name="One way").check()
    await expect(entry).to_contain_text("Lane, one way")
    await shown.save()
    await expect(entry).to_contain_text("Lane 1in forceLane, one way")
    lane = shown.given.zones.zones[2]
    assert msgspec.to_builtins(lane.rule) == {"name": "Lane 1", "kind": "lane", "one_way": True}
    assert len(lane.geometry.coordinates) == 3


async def test_places_of_a_building_are_drawn_and_keep_their_properties(shown: Shown) -> None:
    await shown.add("Door")
    await shown.click((4, 10), (6, 10))  # the second end ends it
    await shown.group.get_by_label("Lift behind it").fill("north")
    await shown.add("Lift")
    await shown.click((4, 11), (6, 11), (6, 13))
    await shown.page.keyboard.press("Enter")
    await shown.group.get_by_label("Id of the lift").fill("north")
    await shown.add("Dock")
    await shown.click((12, 12))
    form = shown.group.get_by_role("form", name="Zone Dock 1")
    await form.get_by_label("Heading").fill("90")
    await form.get_by_role("switch", name="Robots charge here").uncheck()
    await expect(form.get_by_role("button", name="Add hours")).to_have_count(0)
    await shown.save()
    door, lift, dock = rules_of(shown.given.zones)[2:]
    assert door == {"name": "Door 1", "kind": "door", "lift": "north"}
    assert lift == {"name": "Lift 1", "kind": "lift", "lift": "north"}
    assert dock == {"name": "Dock 1", "kind": "dock", "yaw": pytest.approx(1.5708, abs=1e-3), "charges": False}
    assert len(shown.given.zones.zones[2].geometry.coordinates) == 2


async def test_a_line_stays_as_it_is_when_its_kind_changes(shown: Shown) -> None:
    line = {"type": "LineString", "coordinates": [[4.0, 10.0], [12.0, 10.0]]}
    lane = {"type": "Feature", "geometry": line, "properties": {"name": "way", "kind": "lane", "one_way": True}}
    shown.given.replace(zones_of(json.dumps({"type": "FeatureCollection", "features": [lane]})))
    entry, kind = shown.page.get_by_role("button", name="way"), shown.group.get_by_label("Kind")
    await entry.click(timeout=20_000)  # it looks again after ten seconds
    assert await kind.locator("option").all_text_contents() == ["Lane", "One way", "Door"]
    for label, rule in (("One way", {"kind": "one_way", "width": 1.0}), ("Lane", {"kind": "lane"})):
        await kind.select_option(label=label)
        await shown.save()
        await entry.click()
        assert rules_of(shown.given.zones) == [{"name": "way", **rule}]
        assert msgspec.to_builtins(shown.given.zones.zones[0].geometry) == line


async def test_a_zone_is_drawn_by_keyboard_alone(shown: Shown) -> None:
    page = shown.page
    await shown.group.get_by_label("New zone").select_option(label="Capacity")
    await shown.group.get_by_role("button", name="Add zone").press("Enter")
    await expect(page.locator("#map")).to_be_focused()
    for key in ("Space", "ArrowRight", "ArrowRight", "Space", "ArrowDown", "Space", "ArrowDown", "Space", "Backspace"):
        await page.keyboard.press(key)
    await page.keyboard.press("Enter")
    corners = shown.group.get_by_label("Corners")
    assert len((await corners.input_value()).split(",")) == 3
    await corners.fill("1 1, 3 1, 3")
    await corners.press("Enter")
    assert not await corners.evaluate("(field) => field.validity.valid")
    await corners.fill("1 1, 3 1, 3 3")
    await corners.press("Enter")
    await shown.group.get_by_label("Most robots").fill("2")
    await shown.group.get_by_label("Most robots").press("Enter")
    await shown.group.get_by_role("button", name="Save", exact=True).press("Enter")
    await expect(page.locator(".toast").last).to_contain_text("The zones are saved")
    few = shown.given.zones.zones[2]
    assert msgspec.to_builtins(few.rule) == {"name": "Capacity 1", "kind": "capacity", "robots": 2}
    assert few.geometry.coordinates == [[[1, 1], [3, 1], [3, 3], [1, 1]]]


async def test_escape_cancels_a_drawing_and_discard_all_changes(shown: Shown) -> None:
    page = shown.page
    await shown.add("Keep out")
    await shown.click((12, 4), (16, 4))
    await page.keyboard.press("Enter")
    await expect(shown.group.get_by_role("button", name="Finish")).to_be_disabled()
    await page.keyboard.press("Escape")
    await expect(page.locator("#zones > li")).to_have_count(2)
    await expect(shown.group.get_by_role("button", name="Discard")).to_be_hidden()
    await shown.click((6, 6))
    await shown.group.get_by_role("button", name="Remove zone").click()
    await expect(page.locator("#zones > li")).to_have_count(1)
    await expect(page.locator("#zones-note")).to_have_text("Not saved yet")
    await shown.group.get_by_role("button", name="Discard").click()
    await expect(page.locator("#zones > li")).to_have_count(2)
    assert shown.given.asked == []


async def test_a_refusal_is_shown_as_it_is_and_nothing_is_lost(shown: Shown) -> None:
    await shown.page.get_by_role("button", name="aisle").click()
    await shown.group.get_by_label("Kind").focus()
    await shown.group.get_by_label("Kind").select_option(label="Capacity")
    await expect(shown.group.get_by_label("Kind")).to_be_focused()
    shown.given.refusal = "zone <i>'aisle'</i> is too large"
    await shown.group.get_by_role("button", name="Save", exact=True).click()
    await expect(shown.page.locator("#zones-note")).to_have_text("zone <i>'aisle'</i> is too large")
    await expect(shown.page.locator("#zones > li").last).to_contain_text("not savedCapacity 1 robot")
    await shown.save()
    assert rules_of(shown.given.zones)[1] == {"name": "aisle", "kind": "capacity", "robots": 1}


async def test_changes_of_somebody_else_are_told_and_reloaded(shown: Shown) -> None:
    page = shown.page
    await page.get_by_role("button", name="aisle").click()
    await shown.group.get_by_role("button", name="Remove zone").click()
    shown.given.replace(zones({"name": "gate", "kind": "keep_out"}))
    await shown.group.get_by_role("button", name="Save", exact=True).click()
    note = page.locator("#zones-note")
    await expect(note).to_have_text(
        re.compile("^the map has changed since Somebody else has changed the zones meanwhile")
    )
    await expect(shown.group.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    await expect(page.locator("#zones > li")).to_contain_text("dock")
    await shown.group.get_by_role("button", name="Reload").click()
    await expect(page.locator("#zones > li")).to_contain_text("gate")
    await expect(note).to_be_hidden()
    assert rules_of(shown.given.zones) == [{"name": "gate", "kind": "keep_out"}]


async def test_readers_of_a_map_see_its_zones_without_tools(browser: Browser) -> None:
    given = ZonesOfMap(zones({"name": "dock", "kind": "keep_out"}), ["dock"])
    async with serving_map() as (url, _, bob), looking(await desk(browser), EXPECTED) as page:
        await given.answer(page)
        await enter(page, url, bob)
        await page.get_by_role("button", name="dock").click()
        group = page.get_by_role("group", name="Zones")
        await expect(page.get_by_role("button", name="dock")).to_have_attribute("aria-pressed", "true")
        for name in ("Add zone", "Remove zone", "Save"):
            await expect(group.get_by_role("button", name=name)).to_be_hidden()
        given.replace(zones())
        await expect(group).to_be_hidden(timeout=20_000)  # it looks again after ten seconds


async def test_a_zone_is_drawn_by_touch_on_a_phone(browser: Browser) -> None:
    given = ZonesOfMap()
    async with serving_map() as (url, ann, _):
        context = await browser.new_context(viewport=PHONE, has_touch=True, is_mobile=True)
        async with looking(context, EXPECTED) as page:
            await given.answer(page)
            await enter(page, url, ann)
            await page.get_by_role("button", name="Robots", exact=True).tap()
            group = page.get_by_role("group", name="Zones")
            await group.get_by_role("button", name="Add zone").tap()
            eye = await Eye.on(page, GRID.info)
            for x, y in ((4, 4), (16, 4), (16, 12)):
                await page.touchscreen.tap(*eye.see(Pose2D(x, y, 0.0)))
            await group.get_by_role("button", name="Finish").tap()
            await group.get_by_role("button", name="Save", exact=True).tap()
            await expect(page.locator(".toast").last).to_contain_text("The zones are saved")
    assert rules_of(given.zones) == [{"name": "Keep out 1", "kind": "keep_out"}]


async def test_a_crossed_outline_is_marked_on_the_map_before_it_is_saved(shown: Shown) -> None:
    note = shown.page.locator("#zones-note")
    await shown.page.get_by_role("switch", name="Zones").check()
    await shown.add("Capacity")
    await shown.click((12, 10), (16, 14), (16, 10), (12, 14))
    await shown.page.wait_for_function(RED_AT, arg=[*shown.eye.see(Pose2D(14, 12, 0.0)), False])
    await shown.page.keyboard.press("Enter")
    await expect(note).to_contain_text("zone 'Capacity 1': its outline crosses itself at (14")
    await shown.page.wait_for_function(RED_AT, arg=[*shown.eye.see(Pose2D(14, 12, 0.0)), True])
    form = shown.group.get_by_role("form", name="Zone Capacity 1")
    await form.get_by_label("Corners").fill("12 10, 16 10, 16 14, 12 14")
    await form.get_by_label("Corners").press("Tab")
    await expect(note).to_have_text("Not saved yet")
    await shown.page.wait_for_function(RED_AT, arg=[*shown.eye.see(Pose2D(14, 12, 0.0)), False])
    await shown.save()

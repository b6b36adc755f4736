"""Buildings in the dashboard, in a real browser: floors, lifts and doors, journeys, and the record."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from playwright.async_api import Browser, Page, expect

from engine.control.buildings.views import BuildingView, DoorView, LiftView, RideView
from engine.control.journeys.views import JourneyView, SiteView
from ppaas.buildings.building import Building, Floor, json_of
from ppaas.buildings.lifts.states import LiftMode
from ppaas.clock import epoch
from ppaas.maps.formats.map_files import save_map
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from robots.client.rest import RestClient
from tests.e2e.test_dashboard_axe import AXE, expect_no_fault
from tests.support.cloud.browser import enter, looking
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.zones import GRID, serving_map

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]


async def test_buttons_lead_to_the_other_floors_of_the_building(browser: Browser) -> None:
    async with serving_map() as (url, ann, _), looking(await browser.new_context()) as page:
        rest = RestClient(url, ann)
        yaml, image = save_map(GRID, "attic.pgm")
        for map_id in ("attic", "barn"):
            await rest.upload_map(map_id, yaml, image)
        floors = (Floor(name="L1", map="office"), Floor(name="L2", map="attic", elevation=3.5))
        await rest.put_building("inn", json_of(Building(floors=floors)))
        await enter(page, url, ann)
        group = page.get_by_role("group", name="Floor")
        choice = page.locator("#map-choice")
        await choice.select_option("office")
        await expect(group.get_by_role("button")).to_have_text(["L2", "L1"])
        await expect(group.get_by_role("button", name="L1")).to_have_attribute("aria-pressed", "true")
        await group.get_by_role("button", name="L2").click()
        await expect(choice).to_have_value("attic")
        await expect(group.get_by_role("button", name="L2")).to_have_attribute("aria-pressed", "true")
        await choice.select_option("barn")
        await expect(group).to_be_hidden()


CAR = [[2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0], [2.0, 2.0]]
ZONES = ZoneSet(
    [
        Zone(Polygon([CAR]), LiftCar(name="car", lift="north")),
        Zone(LineString([[2.2, 4.1], [3.8, 4.1]]), Door(name="landing", lift="north")),
        Zone(LineString([[8.0, 6.0], [9.5, 6.0]]), Door(name="gate")),
    ]
)
RIDE = RideView("ann/tb1", "L1", "L2", "waiting", 100.0)


def seen(fault: str = "", mode: LiftMode = "agv", floor: str = "L1") -> SiteView:
    lift = LiftView("north", fault, floor, "", "open", "stopped", mode, "", [] if fault else [RIDE])
    journey = JourneyView("journey-1", "ann", "tb1", "L1", "L2", "waiting", "north", "active", "", epoch())
    return SiteView(BuildingView([lift], [DoorView("L1", "gate", "open", ["ann/tb1"])], []), [journey])


@asynccontextmanager
async def inn(journeys: FakeJourneys) -> AsyncIterator[tuple[str, str, RestClient]]:
    """Serve an inn of ann with two floors; return URL and token of ann, and a client."""
    async with serving_map(journeys) as (url, ann, _):
        rest = RestClient(url, ann)
        yaml, image = save_map(GRID, "attic.pgm")
        await rest.upload_map("attic", yaml, image)
        for map_id in ("office", "attic"):
            await rest.put_zones(map_id, geojson_of(ZONES))
        floors = (Floor(name="L1", map="office"), Floor(name="L2", map="attic", elevation=3.5))
        await rest.put_building("inn", json_of(Building(floors=floors)))
        yield url, ann, rest


async def colours(page: Page) -> str:
    """Return the picture of the map."""
    return str(await page.locator("#map").evaluate("(map) => map.toDataURL()"))


async def test_lifts_doors_and_journeys_are_listed_and_drawn_as_they_change(browser: Browser) -> None:
    journeys = FakeJourneys()
    journeys.state = seen()
    async with inn(journeys) as (url, ann, _), looking(await browser.new_context()) as page:
        await enter(page, url, ann)
        await page.locator("#map-choice").select_option("office")
        panel = page.get_by_role("group", name="Building")
        parts, under_way = panel.get_by_role("list", name="Lifts and doors"), panel.get_by_role("list", name="Journeys")
        await expect(parts.get_by_role("listitem").first).to_contain_text(
            "At L1, doors open; tb1 waits at L1 to ride to L2"
        )
        await expect(parts.get_by_role("listitem").last).to_contain_text("Open, held for tb1")
        await expect(under_way.get_by_role("listitem")).to_contain_text("tb1")
        await expect(under_way.get_by_role("listitem")).to_contain_text("waits for north on L1, to L2")
        before = await colours(page)
        journeys.state = seen("lift 'north' is in the mode 'fire'", "fire")
        await expect(panel.locator("#building-note")).to_have_text("1 of the lifts and doors has a fault")
        await expect(parts.get_by_role("listitem").first).to_contain_text("lift 'north' is in the mode 'fire'")
        broken = await colours(page)
        assert broken != before, "it is drawn, too"
        await page.get_by_role("switch", name="Lifts and doors").uncheck()
        await page.wait_for_timeout(300)
        assert await colours(page) not in (before, broken)
        await page.locator("#map-choice").select_option("attic")
        await expect(parts.get_by_role("listitem").first).to_contain_text("fire")


async def test_nothing_is_grave_in_panel_and_record_of_a_building(browser: Browser) -> None:
    if not AXE.exists():
        pytest.skip("no axe-core: run make setup with Node 20 and npm")
    journeys, context = FakeJourneys(), await browser.new_context(viewport={"width": 1440, "height": 900})
    journeys.state = seen("lift 'north' is in the mode 'fire'", "fire")
    await context.add_init_script(path=AXE)
    async with inn(journeys) as (url, ann, _), looking(context) as page:
        await enter(page, url, ann)
        await page.locator("#map-choice").select_option("office")
        await expect(page.locator("#building-note")).to_contain_text("has a fault")
        for scheme in ("light", "dark"):
            await page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
            await expect_no_fault(page, f"panel of a building, {scheme}")
        await page.get_by_role("link", name="Buildings").click()
        for name in ("lift", "door", "way"):
            await page.get_by_role("button", name=f"Add {name}").click()
        for scheme in ("light", "dark"):
            await page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
            await expect_no_fault(page, f"record of a building, {scheme}")


async def test_the_record_of_a_building_is_made_changed_and_kept_from_a_newer_one(browser: Browser) -> None:
    refused = r"^Failed to load resource"
    async with inn(FakeJourneys()) as (url, ann, rest), looking(await browser.new_context(), refused) as page:
        await enter(page, url, ann)
        await page.get_by_role("link", name="Buildings").click()
        building, save = (
            page.get_by_role("combobox", name="Building", exact=True),
            page.get_by_role("button", name="Save", exact=True),
        )
        await expect(building).to_have_value("inn")
        await expect(save).to_be_disabled()
        await page.get_by_role("group", name="Floor L2").get_by_label("Elevation [m]").fill("4.2")
        await page.get_by_role("button", name="Add lift").click()
        lift = page.get_by_role("group", name="Lift", exact=True)
        await lift.get_by_label("Id, as zones name it").fill("north")
        await lift.get_by_label("Device").fill("sim:")
        await page.get_by_role("button", name="Check").click()
        await expect(page.get_by_role("list", name="What may be wrong")).to_contain_text("2 floors, 1 lift")
        await page.get_by_label("Why").fill("a lift")
        await save.click()
        await expect(page.locator("#page")).to_contain_text("Version 2 by ann")
        found = await rest.get("/v1/buildings/inn")
        assert (found["version"], found["message"]) == (2, "a lift")
        assert found["building"]["lifts"] == [{"lift": "north", "device": "sim:"}]
        assert found["building"]["floors"][1] == {"name": "L2", "map": "attic", "elevation": 4.2}

        other = Building(floors=(Floor(name="L1", map="office"),))
        await page.get_by_role("group", name="Lift north").get_by_label("Robots in the car").fill("2")
        await rest.put_building("inn", json_of(other))
        await save.click()
        await expect(page.locator("#page [role=alert]").last).to_contain_text("is at version 3, not at version 2")
        await expect(page.locator("#page")).to_contain_text("ann has made version 3 meanwhile")
        await page.get_by_role("button", name="Reload").click()
        await expect(page.get_by_role("group", name="Floor L2")).to_have_count(0)
        assert (await rest.get("/v1/buildings/inn"))["version"] == 3

        await building.select_option("")
        await page.get_by_label("Id of the new building").fill("hut")
        await page.get_by_role("group", name="Floor", exact=True).get_by_label("Name").fill("ground")
        await page.get_by_role("group", name="Floor", exact=True).get_by_label("Map").select_option("attic")
        await save.click()
        await expect(building).to_have_value("hut")
        assert (await rest.get("/v1/buildings/hut"))["building"] == {"floors": [{"name": "ground", "map": "attic"}]}

"""Floors of a building in the dashboard, in a real browser."""

import pytest
from playwright.async_api import Browser, expect

from ppaas.buildings.building import Building, Floor, json_of
from ppaas.maps.formats.map_files import save_map
from robots.client.rest import RestClient
from tests.support.cloud.browser import enter, looking
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

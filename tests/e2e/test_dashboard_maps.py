"""Maps in the dashboard, in a real browser: one that a robot makes, and changes that wait for a review."""

import re
from dataclasses import replace

import pytest
from playwright.async_api import Browser, expect

from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import OCCUPIED, GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.browser import enter, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.world.places import free_pose

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

NAME_OF_MAP = "annex"

DRAWN = """() => {
    const map = document.getElementById("map");
    const { data } = map.getContext("2d").getImageData(0, 0, map.width, map.height);
    const count = (colour) => data.filter((value, i) => i % 4 === 0 && value === colour).length;
    return count(255) > 2000; // free cells are white
}"""
"""Whether the canvas shows free cells."""


async def propose(rest: RestClient, grid: GridMap, number: int) -> str:
    """Publish a version with a shelf, which waits for a review; return the version."""
    cells = grid.data.copy()
    cells[40 + 10 * number : 44 + 10 * number, 40:60] = OCCUPIED
    yaml, image = save_map(replace(grid, data=cells), "hall.pgm")
    answer = await rest.upload_map("hall", yaml, image, review="true", message=f"shelf {number}")
    return str(answer["version"])


async def login_of(cloud: RunningCloud, user: str) -> tuple[RestClient, str]:
    """Return a client of a new user, and its token."""
    admin, rest = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": user, "password": ADMIN_PASSWORD})
    return rest, (await rest.login(user, ADMIN_PASSWORD)).token


async def test_a_map_is_drawn_while_a_robot_makes_it_and_published(
    cloud: RunningCloud, office_map: GridMap, browser: Browser
) -> None:
    rest, token = await login_of(cloud, "mapper")
    await rest.put_robot("scout", RobotFile(map=f"new:{NAME_OF_MAP}"))
    start = free_pose(office_map, seed=4)
    robot_drives = driving(cloud.url, token, "scout", office_map, start)
    async with robot_drives, looking(await browser.new_context()) as page:
        await enter(page, cloud.url, token)
        await expect(page.locator("#map-choice option")).to_have_text(f"{NAME_OF_MAP}, being made (1)")
        robot = page.get_by_role("button", name="scout")
        await expect(robot).to_contain_text("online")
        await robot.click()
        await page.wait_for_function(DRAWN)
        await expect(page.get_by_role("button", name="Explore")).to_be_enabled()
        await page.get_by_text("Publish its map").click()
        await expect(page.get_by_label("Name", exact=True)).to_have_value(NAME_OF_MAP)
        await page.get_by_role("button", name="Publish").click()
        await expect(page.locator(".toast")).to_have_text(f"{NAME_OF_MAP} is published: robots can drive on it")
    assert (await rest.get(f"/v1/maps/{NAME_OF_MAP}"))["parts"] == ["image", "posegraph", "yaml"]


async def test_a_change_is_shown_and_approved_or_refused(
    cloud: RunningCloud, office_map: GridMap, browser: Browser
) -> None:
    rest, token = await login_of(cloud, "surveyor")
    await publish_map(rest, "hall", office_map)
    reviewed = [await propose(rest, office_map, number) for number in (1, 2)]
    async with looking(await browser.new_context()) as page:
        await enter(page, cloud.url, token)
        first, second = page.locator("#reviews > li").last, page.locator("#reviews > li").first
        await expect(first).to_contain_text("by surveyor: shelf 1")
        await expect(first).to_contain_text(re.compile(r"Now \d+ cells occupied"))
        await second.get_by_label("Reason").fill("it was a person")
        await second.get_by_role("button", name="Refuse").click()
        await expect(page.locator("#reviews > li")).to_have_count(1)
        await page.get_by_role("button", name="Approve").click()
        await expect(page.locator("#panel-map")).to_be_hidden()
    states = {one["version"]: one["state"] for one in await rest.items("/v1/maps/hall/reviews")}
    assert [states[version] for version in reviewed] == ["approved", "refused"]
    assert (await rest.get("/v1/maps/hall"))["version"] == reviewed[0]

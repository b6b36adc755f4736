"""Maps and recordings on pages of the dashboard, with the REST service of a cloud and made-up robots."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.async_api import Page, expect
from starlette.types import ASGIApp

from endpoints.resources.services import Services
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import OCCUPIED
from storage.records import ProposedChange
from tests.support.cloud.browser import DESK, PHONE, browsing, enter, looking
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.endpoints.zones import GRID
from tests.support.recordings.kept import kept_recordings
from tests.support.storage.records import GivenMap, propose

pytestmark = pytest.mark.journey

REFUSED = r"^Failed to load resource"
COLOUR = "one => getComputedStyle(one).color"
DIFFERENT = """() => {
    const [now, then] = [...document.querySelectorAll(".before-after canvas")].map((canvas) =>
        [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data]);
    return now.length === then.length && now.some((value, i) => value !== then[i]);
}"""
"""Whether the two pictures of a version that waits differ."""


SHELF = ProposedChange(occupied=480, rectangles=((180, 40, 40, 12),))


def with_a_shelf() -> GivenMap:
    """Return ann's map with a shelf."""
    cells = GRID.data.copy()
    cells[40:52, 180:220] = OCCUPIED
    yaml, image = save_map(replace(GRID, data=cells), "office.pgm")
    return GivenMap("office", "ann", yaml, image)


@asynccontextmanager
async def showing(title: str, expected: str = r"$^") -> AsyncIterator[tuple[Page, Services]]:
    """Open a page of a fleet whose first robot has a recording."""
    kept: list[Services] = []

    def remembered(app: ASGIApp) -> ASGIApp:
        kept.append(app.state.services)  # type: ignore[attr-defined]  # of FastAPI
        return app

    sockets = RobotSockets()
    async with serving_fleet(6, around=remembered) as (url, token, cloud), browsing() as browser:
        object.__setattr__(kept[0], "recordings", kept_recordings(cloud, "ann", "tb0"))
        async with looking(await browser.new_context(viewport=DESK), expected) as page:
            page.on("dialog", lambda question: question.accept())
            await sockets.answer(page)
            await enter(page, url, token)
            await page.get_by_role("link", name=title).click()
            yield page, kept[0]


async def test_a_version_that_waits_is_compared_approved_and_rolled_back() -> None:
    async with showing("Maps") as (page, services):
        first = services.map_store.map_head("office").version
        review = propose(services.map_store, with_a_shelf(), change=SHELF, message="a shelf")
        waiting = page.get_by_role("list", name="Versions that wait for a review").get_by_role("listitem")
        await expect(waiting.get_by_role("img")).to_have_count(2)
        assert await page.evaluate(DIFFERENT)
        await waiting.get_by_role("button", name="Approve").click()
        await expect(waiting).to_have_count(0)
        await expect(page.get_by_role("list", name="Last reviews")).to_contain_text("was approved by ann")
        rows = page.get_by_role("table", name="Versions").locator("tbody tr")
        await expect(rows.first).to_contain_text("a shelf")
        assert services.map_store.map_head("office").version == review.version
        await rows.nth(1).get_by_role("button", name="Roll back").click()
        await expect(rows.first).to_contain_text("rolled back")
        assert services.map_store.map_head("office").version == first


async def test_a_map_is_published_from_its_files_shown_and_removed(tmp_path: Path) -> None:
    yaml, image = save_map(GRID, "hall.pgm")
    (tmp_path / "hall.yaml").write_bytes(yaml)
    (tmp_path / "hall.pgm").write_bytes(image)
    async with showing("Maps", REFUSED) as (page, services):
        await page.get_by_text("Publish a map").click()
        form = page.get_by_role("form", name="Publish a map")
        await form.get_by_label("Name", exact=True).fill("hall 2")
        await form.get_by_label("YAML").set_input_files(tmp_path / "hall.yaml")
        await form.get_by_label("Image").set_input_files(tmp_path / "hall.pgm")
        await form.get_by_role("button", name="Publish").click()
        await expect(form.get_by_role("alert")).to_contain_text("not a valid name")
        await form.get_by_label("Name", exact=True).fill("hall")
        await form.get_by_role("button", name="Publish").click()
        card = page.get_by_role("list", name="Maps").get_by_role("listitem").filter(has_text="hall")
        await expect(card).to_contain_text("of ann")
        await card.get_by_role("button", name="Versions of hall").click()
        await expect(page.get_by_role("combobox", name="Map", exact=True)).to_have_value("hall")
        await expect(page.locator("#page h3")).to_have_text("Versions of hall")
        await card.get_by_role("button", name="Remove").click()
        await expect(card).to_have_count(0)
        assert [head.id for head in services.map_store.maps()] == ["office"]


async def test_recordings_of_all_robots_are_found_fetched_and_deleted() -> None:
    async with showing("Recordings") as (page, services):
        rows = page.get_by_role("table", name="Recordings").locator("tbody tr")
        await expect(rows).to_have_count(1)
        robot, size = rows.locator("td").first, rows.locator("td").nth(2)
        assert await size.evaluate(COLOUR) == await robot.evaluate(COLOUR), "the size looks like a refusal"
        await page.set_viewport_size(PHONE)
        assert await rows.get_by_role("button").first.evaluate("one => one.clientHeight") < 60, "its text is broken"
        await page.set_viewport_size(DESK)
        await page.get_by_role("searchbox", name="Robot").fill("tb5")
        await expect(rows).to_have_count(0)
        await page.get_by_role("searchbox", name="Robot").fill("TB")
        async with page.expect_download() as fetched:
            await rows.get_by_role("button", name="Download").click()
        assert (await fetched.value).suggested_filename.startswith("tb0-20261126T224142Z")
        await rows.get_by_role("button", name="Delete").click()
        await expect(page.locator("#page").get_by_role("status")).to_contain_text("No recordings")
        assert services.recordings is not None
        assert services.recordings.recordings("ann", "tb0") == []

"""The dashboard by the rules of axe, in light and dark, on a desk and on a phone: nothing critical or serious."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio
from playwright.async_api import Browser, BrowserContext, Page, expect
from starlette.types import ASGIApp

from endpoints.resources.services import Services
from tests.e2e.test_dashboard_zones import zones
from tests.support.cloud.browser import PHONE, enter, looking
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.endpoints.zones import ZonesOfMap
from tests.support.recordings.kept import kept_recordings

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

AXE = Path(__file__).parent / "axe" / "node_modules" / "axe-core" / "axe.min.js"
GRAVE = ("critical", "serious")
FORMS = "#page .page-parts > .go > summary:visible, #page section > .go > summary:visible"
LOOKS = [
    pytest.param({"viewport": size, "color_scheme": scheme}, id=f"{name}-{scheme}")
    for name, size in (("desk", {"width": 1440, "height": 900}), ("phone", PHONE))
    for scheme in ("light", "dark")
]

FAULTS = """async (grave) => (await axe.run()).violations
    .filter(({ impact }) => grave.includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ target, any }) => `${id}: ${target} ${any[0]?.message ?? ""}`))"""


@pytest_asyncio.fixture(loop_scope="module", params=LOOKS)
async def context(request: pytest.FixtureRequest, browser: Browser) -> AsyncIterator[BrowserContext]:
    """Return a browser context of one size and colour scheme, which the page may not forbid to run axe."""
    if not AXE.exists():
        pytest.skip("no axe-core: run make setup with Node 20 and npm")
    fresh = await browser.new_context(**request.param)
    await fresh.add_init_script(path=AXE)
    yield fresh
    await fresh.close()


async def test_nothing_is_grave_at_the_login(context: BrowserContext) -> None:
    async with serving_fleet(1) as (url, _, _), looking(context) as page:
        await page.goto(f"{url}/dashboard/")
        await expect(page.get_by_role("button", name="Log in")).to_be_visible()
        await expect_no_fault(page, "login")


async def test_nothing_is_grave_on_map_and_panels(context: BrowserContext) -> None:
    async with showing(context) as page:
        await expect_no_fault(page, "map")
        for panel in ("load", "layers", "robots"):
            await open_panel(page, panel)
            await expect_no_fault(page, panel)


async def test_nothing_is_grave_on_cards_of_robots(context: BrowserContext) -> None:
    async with showing(context) as page:
        for number, said in ((1, "There is no way"), (2, "No pose"), (4, "Not connected")):
            await open_panel(page, "robots")
            await page.locator("#robots .robot").nth(number).click()
            await expect(page.locator("#robot-card .doing")).to_contain_text(said)
            await page.locator("#robot-card summary", has_text="Drive to coordinates").click()
            await expect_no_fault(page, f"card of {said}")


async def test_nothing_is_grave_on_forms_of_zones(context: BrowserContext) -> None:
    async with showing(context) as page:
        await open_panel(page, "robots")
        for zone in await page.locator("#zones .robot").all():
            await zone.click()
            await expect(page.locator("#panel-robots .zone-form")).to_be_visible()
            await expect_no_fault(page, "form of a zone")


async def test_nothing_is_grave_in_the_table_of_robots(context: BrowserContext) -> None:
    async with showing(context) as page:
        await page.get_by_role("button", name="Fleet").click()
        await expect(page.locator("#fleet tbody tr")).to_have_count(5)
        await expect_no_fault(page, "fleet")


async def test_nothing_is_grave_while_robots_are_stopped_and_on_the_question_of_a_release(
    context: BrowserContext,
) -> None:
    async with showing(context) as page:
        await page.get_by_role("button", name="STOP ALL").click()
        await expect(page.locator("#stopped")).to_contain_text("All robots are stopped by ann")
        await expect(page.locator("#toasts")).to_contain_text("All robots are stopped")
        await expect_no_fault(page, "stopped")
        await page.locator("#stopped").get_by_role("button", name="Release…").click()
        await expect_no_fault(page, "release")


async def test_nothing_is_grave_on_pages_and_their_forms(context: BrowserContext) -> None:
    async with showing(context) as page:
        await add_tasks(page)
        for title, shown in (
            ("Tasks", ".task"),
            ("Events", "tr"),
            ("Maps", ".table th"),
            ("Buildings", "label"),
            ("Recordings", "tbody td"),
            ("Robots", ".cards li"),
            ("Access", ".cards li"),
            ("Plans", "th"),
        ):
            await page.get_by_role("link", name=title).click()
            await expect(page.locator("#page h2")).to_have_text(title)
            await expect(page.locator(f"#page {shown}").nth(1)).to_be_attached()
            for form in await page.locator(FORMS).all():
                await form.click()
            await expect_no_fault(page, title)
        await page.get_by_role("link", name="Robots").click()
        await page.get_by_role("button", name="New token for tb0").click()
        await expect(page.get_by_role("dialog", name="Token of robot tb0")).to_be_visible()
        await expect_no_fault(page, "token")


async def add_tasks(page: Page) -> None:
    """Add a task that waits, and one that was cancelled."""
    token = await page.evaluate("sessionStorage.getItem('ppaas-token')")
    headers, tasks = (
        {"Authorization": f"Bearer {token}"},
        page.url.partition("/dashboard/")[0] + "/v1/maps/office/tasks",
    )
    for priority in (1, 2):
        task = {"kind": "go_to", "places": [[1.0, 2.0]], "priority": priority, "labels": {"lift": "yes"}}
        answer = await page.request.post(tasks, headers=headers, data=task)
        assert answer.status == 201
    await page.request.delete(f"{tasks}/{(await answer.json())['id']}", headers=headers)


@asynccontextmanager
async def showing(context: BrowserContext) -> AsyncIterator[Page]:
    """Show a map with zones, and robots of which one fails, some are silent, and the last is not connected."""
    sockets, drawn = RobotSockets(), zones({"name": "Dock", "kind": "keep_out"}, {"name": "Store", "kind": "no_stop"})
    served = serving_fleet(5, lambda number: number < 4, around=with_recordings)
    async with served as (url, token, _), sockets.beating(), looking(context) as page:
        await sockets.answer(page)
        await ZonesOfMap(drawn, ["Dock"]).answer(page)
        await enter(page, url, token)
        for name in ("tb0", "tb1"):
            await expect(page.locator("#robots > li", has_text=name)).to_contain_text("No pose of it comes")
            sockets.place(name, 3.0, 5.0)
        sockets.status("tb1", 4, "There is no way to the goal")
        yield page


def with_recordings(app: ASGIApp) -> ASGIApp:
    """Give the service a folder with a recording of the first robot."""
    services: Services = app.state.services  # type: ignore[attr-defined]  # of FastAPI
    object.__setattr__(services, "recordings", kept_recordings(FakeCloud(), "ann", "tb0"))
    return app


async def open_panel(page: Page, name: str) -> None:
    """Open a panel; on a desk it is open."""
    panel, tab = page.locator(f"#panel-{name}"), page.locator(f".tab[data-panel={name}]")
    if not await panel.is_visible():
        await tab.click()
        await expect(panel).to_be_visible()


async def expect_no_fault(page: Page, what: str) -> None:
    """Run axe on a page, and fail if a fault is grave."""
    found: list[Any] = await page.evaluate(FAULTS, list(GRAVE))
    assert not found, f"{what}: {found}"

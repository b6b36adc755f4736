"""Traffic of robots in the dashboard, in a real browser, with a cloud whose traffic the test sets."""

import asyncio
import re
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass

import pytest
import pytest_asyncio
from msgspec.structs import replace
from playwright.async_api import Browser, Page, Request, expect

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import TrafficState
from tests.support.cloud.browser import DESK, enter, looking
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.traffic import serving_traffic
from tests.support.waiting import until

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

UNAVAILABLE = r"^Failed to load resource: .* 503"
KEY = ("ann", "house")

COLOURS = """() => {
    const map = document.getElementById("map");
    const { data } = map.getContext("2d").getImageData(0, 0, map.width, map.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add(data.slice(i, i + 3).join());
    return [...seen];
}"""


@dataclass
class Watched:
    """A page that shows the traffic of a fake cloud."""

    page: Page
    cloud: FakeCloud
    asked: list[float]
    """Times at which the page has asked for the traffic [s]."""

    def change(self, at: float, goals: int, **first: object) -> None:
        """Let time pass in the traffic, goals be reached, and the first robot change."""
        state: TrafficState = self.cloud.traffic_states[KEY]
        robots = [replace(state.robots[0], **first), *state.robots[1:]]
        header = Header(stamp=Time.of(at), frame_id="map")
        self.cloud.traffic_states[KEY] = replace(state, header=header, robots=robots, goals=goals)


@pytest_asyncio.fixture(loop_scope="module")
async def watched(browser: Browser) -> AsyncIterator[Watched]:
    """Return a page of ann, who has two robots in the traffic of the map house."""
    async with serving_traffic() as (url, token, cloud):
        context = await browser.new_context(viewport=DESK)
        async with looking(context, rf"{UNAVAILABLE}|willReadFrequently") as page:
            asked: list[float] = []

            def note(request: Request) -> None:
                if request.url.endswith("/v1/maps/house/traffic"):
                    asked.append(asyncio.get_running_loop().time())

            page.on("request", note)
            await enter(page, url, token)
            yield Watched(page, cloud, asked)


async def test_robots_are_listed_with_what_they_wait_for_and_goals_are_counted(watched: Watched) -> None:
    page = watched.page
    first, second = page.locator("#traffic > li").first, page.locator("#traffic > li").last
    await expect(first).to_contain_text("Waits for tb2, 3 s; goal 4.0, 2.0; holds 2 cells")
    await expect(second).to_contain_text("idle")
    await expect(page.locator("#traffic-note")).to_have_text("0 goals reached in the last minute")
    await expect(page.locator("#traffic-legend")).to_be_hidden()
    watched.change(130.5, 14, waits_for="<b>tb2", waited=33.5)
    await expect(first).to_contain_text("Waits for <b>tb2, 33 s")
    await expect(page.locator("#traffic-note")).to_have_text("2 goals reached in the last minute")
    await expect(page.locator("#traffic-longest")).to_have_text("30 s")
    assert await page.locator("#traffic b").count() == 0
    await until(lambda: len(watched.asked) >= 4)
    assert watched.asked[3] - watched.asked[1] > 1.5, "about once a second"


async def test_ways_and_waits_are_drawn_until_they_are_hidden(watched: Watched) -> None:
    page = watched.page
    await expect(page.locator("#traffic > li")).to_have_count(2)
    for _ in range(10):  # the map is smaller than a cell
        await page.locator("#map").press("-")
    ways = await drawn(page, lambda colours: len(colours) >= 4)
    await page.get_by_role("switch", name="Traffic").uncheck()
    await drawn(page, lambda colours: len(colours) == 2)
    await page.get_by_role("switch", name="Traffic").check()
    await drawn(page, lambda colours: colours == ways)
    watched.change(130.5, 12, waited=33.5)
    await expect(page.locator("#traffic-longest")).to_have_text("30 s")
    await drawn(page, lambda colours: bool(colours - ways))
    heat = page.get_by_role("button", name="Where they waited")
    await expect(heat).to_have_attribute("aria-pressed", "true")
    await heat.press("Enter")
    await expect(heat).to_have_attribute("aria-pressed", "false")
    await expect(page.locator("#traffic-legend")).to_be_hidden()
    await drawn(page, lambda colours: colours == ways)


async def test_a_robot_is_taken_out_and_put_back_by_keyboard(watched: Watched) -> None:
    page, cloud = watched.page, watched.cloud
    group = page.get_by_role("group", name="Traffic")
    await expect(group.get_by_role("button", name="Take out")).to_be_hidden()
    await group.get_by_role("button", name=re.compile("^tb1")).press("Enter")
    page.once("dialog", lambda question: question.dismiss())
    await group.get_by_role("button", name="Take out").press("Enter")
    assert cloud.taken_out == set()
    page.once("dialog", lambda question: question.accept())
    await group.get_by_role("button", name="Take out").press("Enter")
    await expect(page.locator(".toast").last).to_have_text("tb1 is taken out of the traffic")
    assert cloud.taken_out == {("ann", "house", "tb1")}
    watched.change(101.5, 12, state="out", waits_for="", way=[])
    await group.get_by_role("button", name="Put back").press("Enter")
    await expect(page.locator(".toast").last).to_have_text("tb1 is put back into the traffic")
    assert cloud.taken_out == set()


async def test_traffic_that_ends_is_hidden_and_asked_for_less_often(watched: Watched) -> None:
    page, cloud = watched.page, watched.cloud
    group = page.get_by_role("group", name="Traffic")
    await expect(group).to_be_visible()
    state = cloud.traffic_states.pop(KEY)
    await expect(group).to_be_hidden()
    before = len(watched.asked)
    await asyncio.sleep(2.5)
    assert len(watched.asked) == before
    traffic_node, cloud.running = cloud.running, []
    cloud.traffic_states[KEY] = state
    await asyncio.sleep(2.5)  # until the page knows that the node is gone
    assert len(watched.asked) == before, "nothing is asked for without a traffic node"
    cloud.running = traffic_node
    await expect(group).to_be_visible()


async def drawn(page: Page, wanted: Callable[[set[str]], bool]) -> set[str]:
    """Wait until the colours of the map are those that are wanted, and no longer change; return them."""
    colours: set[str] = set()
    for _ in range(100):
        before, colours = colours, set(await page.evaluate(COLOURS))
        if wanted(colours) and colours == before:
            return colours
        await asyncio.sleep(0.2)
    raise AssertionError(f"the map has other colours: {sorted(colours)}")

"""Pages of the dashboard in a real browser, beside a real cloud: tasks, events, robots, access and plans."""

import re
from collections.abc import AsyncIterator
from dataclasses import dataclass

import pytest
import pytest_asyncio
from playwright.async_api import Browser, BrowserContext, Locator, Page, expect

from ppaas.clock import epoch
from ppaas.errors import NotAuthenticated
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.browser import DESK, browsing, enter, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.network.wire import wire_to
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

USER, MAP = "olga", "stock"
REFUSED = r"^Failed to load resource"


@dataclass
class Scene:
    """A cloud with an administrator of its own, who has a map, and a browser."""

    cloud: RunningCloud
    browser: Browser
    grid: GridMap
    rest: RestClient

    @property
    def token(self) -> str:
        """Token of the administrator."""
        assert self.rest.token is not None
        return self.rest.token


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def scene(cloud: RunningCloud, office_map: GridMap) -> AsyncIterator[Scene]:
    """Return a browser beside a cloud."""
    admin, rest = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": USER, "password": ADMIN_PASSWORD, "role": "admin"})
    await rest.login(USER, ADMIN_PASSWORD)
    await publish_map(rest, MAP, office_map)
    async with browsing() as browser:
        yield Scene(cloud, browser, office_map, rest)


@pytest_asyncio.fixture(loop_scope="module")
async def context(scene: Scene) -> AsyncIterator[BrowserContext]:
    """Return a browser context without data of other tests."""
    fresh = await scene.browser.new_context(viewport=DESK)
    yield fresh
    await fresh.close()


async def show(page: Page, scene: Scene, title: str) -> None:
    """Open a page of the dashboard on the map of the test."""
    await enter(page, scene.cloud.url, scene.token)
    await expect(page.locator("#map-choice")).to_be_enabled()
    await page.locator("#map-choice").select_option(MAP)
    await page.get_by_role("navigation", name="Pages").get_by_role("link", name=title).click()
    await expect(page.locator("#page h2")).to_have_text(title)


async def test_a_task_is_added_driven_and_done_again(scene: Scene, context: BrowserContext) -> None:
    start = free_pose(scene.grid, seed=1)
    near = min((reachable_pose(scene.grid, start, seed, at_least=1.0) for seed in range(20)), key=start.distance_to)
    token = await register_robot(scene.rest, "carrier", MAP, start)
    async with driving(scene.cloud.url, token, "carrier", scene.grid, start), looking(context) as page:
        await show(page, scene, "Tasks")
        await page.get_by_text("Add a task").click()
        await page.get_by_role("textbox", name="Places").fill("far away")
        await page.get_by_role("button", name="Add", exact=True).click()
        await expect(page.get_by_role("alert").last).to_contain_text("“far away” is no place")
        await page.get_by_role("textbox", name="Places").fill(f"{near.x:.2f} {near.y:.2f}")
        await page.get_by_role("button", name="Add", exact=True).click()
        done = page.get_by_role("region", name="Done").get_by_role("listitem")
        await expect(done).to_contain_text("carrier", timeout=60_000)
        await done.get_by_role("button", name="Do again").click()
        await expect(done).to_have_count(2, timeout=60_000)
        await done.first.get_by_role("button", name="carrier", exact=True).click()
        await expect(page.locator("#robot-card .name")).to_have_text("carrier")
        assert page.url.endswith("/dashboard/#")
    tasks = await scene.rest.items(f"/v1/maps/{MAP}/tasks")
    assert [task["state"] for task in tasks] == ["done", "done"]


async def test_a_task_that_failed_is_retried_and_cancelled(scene: Scene, context: BrowserContext) -> None:
    late = {"kind": "go_to", "places": [[2.0, 2.0]], "labels": {"lift": "yes"}, "deadline": epoch() + 0.5}
    await scene.rest.post(f"/v1/maps/{MAP}/tasks", late)
    async with looking(context) as page:
        await show(page, scene, "Tasks")
        waiting, failed = (
            page.get_by_role("region", name=name).get_by_role("listitem") for name in ("Waiting", "Failed")
        )
        await expect(failed).to_contain_text("lift=yes")
        await expect(failed.locator(".error")).not_to_be_empty()
        await failed.get_by_role("button", name="Retry").click()
        await expect(waiting).to_contain_text("waits for")
        await waiting.get_by_role("button", name="Cancel").click()
        await expect(failed).to_have_count(2)
        await expect(failed.first).to_contain_text("cancelled")
        await page.get_by_role("link", name="Events").click()
        alert = (
            page.get_by_role("region", name="Alerts")
            .get_by_role("listitem", name="")
            .filter(has_text=f"A task on {MAP}")
        )
        await expect(alert).to_be_visible()


def alerts_of(page: Page) -> Locator:
    """Return the alerts that nobody has acknowledged."""
    return page.get_by_role("list", name="Alerts", exact=True).get_by_role("listitem")


async def test_a_lost_robot_is_an_alert_and_its_events_are_found(scene: Scene, context: BrowserContext) -> None:
    token = await register_robot(scene.rest, "loner", MAP, free_pose(scene.grid, seed=2))
    async with wire_to(scene.cloud.url) as wire, RobotClient(wire.url, robot="loner", token=token):
        wire.cut()
    async with looking(context) as page:
        await show(page, scene, "Events")
        lost = alerts_of(page).filter(has_text="loner is lost")
        await expect(lost).to_be_visible()
        badge = page.get_by_role("link", name="Events").locator(".badge")
        count = int(await badge.inner_text())
        await lost.get_by_role("button", name="Acknowledge").click()
        await expect(lost).to_be_hidden()
        await expect(badge).to_have_text(str(count - 1))
        async with looking(await scene.browser.new_context(viewport=DESK)) as other:
            await show(other, scene, "Events")
            await other.get_by_text("Acknowledged (").click()
            seen = other.get_by_role("list", name="Acknowledged alerts").get_by_role("listitem")
            await expect(seen.filter(has_text="loner is lost")).to_contain_text(f"acknowledged by {USER}")
            await expect(alerts_of(other).filter(has_text="loner is lost")).to_have_count(0)
            await other.context.close()
        await page.get_by_label("Robot", exact=True).fill("loner")
        await page.keyboard.press("Enter")
        rows = page.get_by_role("table").locator("tbody tr")
        await expect(rows.filter(has_text=re.compile("role robot, .*code 100[56]"))).to_contain_text("disconnect")
        await expect(rows.last).to_contain_text("put robot")
        assert await rows.filter(has_text="carrier").count() == 0
        await page.get_by_label("Kind").select_option("Changes")
        await expect(rows).to_have_count(2)
        await expect(rows.first).to_contain_text("acknowledge alert")
        await scene.rest.patch("/v1/robots/loner", {"description": "alone"})
        await expect(rows.first).to_contain_text("change robot")


async def test_a_robot_is_added_with_a_token_that_is_shown_once(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, REFUSED) as page:
        await show(page, scene, "Robots")
        await page.get_by_text("Add a robot").click()
        form = page.get_by_role("form", name="Add a robot")
        await form.get_by_label("Name", exact=True).fill("newbie")
        await form.get_by_label("Map").select_option(MAP)
        await form.get_by_label("Heading").fill("90")
        await form.get_by_role("button").click()
        dialog = page.get_by_role("dialog", name="Token of robot newbie")
        given = await dialog.get_by_label("Secret").input_value()
        found = re.fullmatch(r"PPAAS_URL=(\S+)\nPPAAS_TOKEN=(\S+)\n", given)
        assert found and found[1] == scene.cloud.url
        await dialog.get_by_role("button", name="Close").click()
        assert found[2] not in await page.content()
        entry = page.locator(".cards > li").filter(has_text="newbie")
        await expect(entry).to_contain_text("not connected")
        async with RobotClient(found[1], robot="newbie", token=found[2]):
            await expect(entry.locator(".presence")).to_have_text("connected")
        await form.get_by_label("Name", exact=True).fill("newbie")
        await form.get_by_role("button").click()
        await expect(form.get_by_role("alert")).to_have_text("There is a robot newbie already")
        await expect(entry.locator(".presence")).to_have_text("not connected")
        page.once("dialog", lambda question: question.accept())
        await entry.get_by_role("button", name="Remove").click()
        await expect(entry).to_be_hidden()
    pose = (await scene.rest.items("/v1/audit", 1, action="put_robot", object="robots/newbie"))[0]
    assert pose["details"]["map"] == MAP


async def test_users_are_created_locked_and_removed(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, REFUSED) as page:
        page.on("dialog", lambda question: question.accept())
        await show(page, scene, "Access")
        await page.get_by_text("Create a user").click()
        form = page.get_by_role("form", name="Create a user")
        await form.get_by_label("Name").fill("vera")
        await form.get_by_label("Password").fill(ADMIN_PASSWORD)
        await form.get_by_label("Groups").fill("hall, night")
        await form.get_by_role("button").click()
        entry = page.get_by_role("region", name="Users").get_by_role("listitem").filter(has_text="vera")
        await expect(entry).to_contain_text("In hall, night")
        vera = RestClient(scene.cloud.url)
        await vera.login("vera", ADMIN_PASSWORD)
        await entry.get_by_role("button", name="Lock").click()
        await expect(page.locator(".toast").last).to_have_text("vera is locked")
        with pytest.raises(NotAuthenticated):
            await vera.get("/v1/users/me")
        with pytest.raises(NotAuthenticated):
            await vera.login("vera", ADMIN_PASSWORD)
        await entry.get_by_text("New password").first.click()
        await entry.get_by_role("textbox", name="New password").fill("another secret")
        await entry.get_by_role("button", name="Set").click()
        await expect(page.locator(".toast").last).to_contain_text("vera has a new password")
        await vera.login("vera", "another secret")
        await entry.get_by_role("combobox").select_option("Administrator")
        await expect(page.locator(".toast").last).to_have_text("vera is administrator now")
        assert (await vera.get("/v1/users/me"))["role"] == "admin"
        await entry.get_by_role("button", name="Remove").click()
        await expect(entry).to_be_hidden()


async def test_a_token_for_some_robots_is_created_and_revoked(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, REFUSED) as page:
        page.on("dialog", lambda question: question.accept())
        await show(page, scene, "Access")
        await page.get_by_text("Create a token for some robots").click()
        form = page.get_by_role("form", name="Create a token")
        await form.get_by_label("What it is for").fill("<b>display")
        await form.get_by_label("Robots").fill("tb 1/2")
        await form.get_by_role("button").click()
        await expect(form.get_by_role("alert")).not_to_be_empty()
        await form.get_by_label("Robots").fill("car*, lon*")
        await form.get_by_role("button").click()
        dialog = page.get_by_role("dialog", name="Token: <b>display")
        display = RestClient(scene.cloud.url, await dialog.get_by_label("Secret").input_value())
        await page.keyboard.press("Escape")
        entry = page.get_by_role("region", name="Your tokens").get_by_role("listitem").filter(has_text="<b>display")
        await expect(entry).to_contain_text("Looks at car*, lon*")
        assert {robot["role"] for robot in await display.items("/v1/robots")} <= {"look"}
        await entry.get_by_role("button", name="Revoke").click()
        await expect(entry).to_be_hidden()
        with pytest.raises(NotAuthenticated):
            await display.get("/v1/robots")


async def test_stored_paths_and_their_reuse_are_shown(scene: Scene, context: BrowserContext) -> None:
    start, goal = free_pose(scene.grid, seed=3), free_pose(scene.grid, seed=9)
    wanted = {"start": [start.x, start.y], "goal": [goal.x, goal.y], "planner": "dijkstra"}
    for _ in range(2):
        await scene.rest.post(f"/v1/maps/{MAP}/plans", wanted)
    async with looking(context) as page:
        await show(page, scene, "Plans")
        await expect(page.locator("#page").get_by_role("status")).to_contain_text(re.compile(r"\d paths? stored in"))
        await expect(page.get_by_role("table", name="Planners").locator("tbody tr")).to_contain_text("dijkstra")
        last = page.get_by_role("table", name="The last paths").locator("tbody tr").first
        await expect(last).to_contain_text(f"{start.x:.1f}, {start.y:.1f}")


async def test_the_browser_goes_back_to_the_map_and_others_see_no_users(scene: Scene, context: BrowserContext) -> None:
    await scene.rest.post("/v1/users", {"id": "sam", "password": ADMIN_PASSWORD})
    sam = RestClient(scene.cloud.url)
    token = (await sam.login("sam", ADMIN_PASSWORD)).token
    async with looking(context) as page:
        await enter(page, scene.cloud.url, token)
        await page.get_by_role("link", name="Access").click()
        await expect(page.get_by_role("region", name="Your tokens").get_by_role("listitem")).to_have_count(1)
        await expect(page.get_by_role("region", name="Users")).to_be_hidden()
        await page.get_by_role("link", name="Events").click()
        await expect(page.get_by_role("region", name="Timeline")).to_contain_text(
            "administrators see the audit log, too"
        )
        await page.reload()
        await expect(page.locator("#page h2")).to_have_text("Events")
        await page.go_back()
        await page.go_back()
        await expect(page.locator("#page")).to_be_hidden()
        await expect(page.locator("#map")).to_be_visible()

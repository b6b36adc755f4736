"""The dashboard in a real browser, with a driving robot."""

import asyncio
import base64
import io
import json
import re
from collections.abc import AsyncIterator
from dataclasses import dataclass, field, replace

import pytest
import pytest_asyncio
from PIL import Image
from playwright.async_api import Browser, BrowserContext, Dialog, Page, Route, WebSocket, expect
from websockets.asyncio.client import connect

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.people.settings import PeopleSettings
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.browser import DESK, PHONE, Eye, browsing, enter, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.endpoints.people import serving_people
from tests.support.network.forwarder import Forwarder
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

TOUCH = 44
FETCH_FAILED = r"^Failed to load resource"
"""Message of Chromium for each error response."""
READ_BACK = "willReadFrequently"
"""Warning of Chromium when pixels are read, which only tests do."""

GONE = rf"{FETCH_FAILED}|^WebSocket connection to .* failed"
"""Messages of Chromium if the cloud or a login ends while the page opens its sockets."""


@dataclass
class Scene:
    """A cloud with its own user, who has one robot on a map with a rotated origin."""

    cloud: RunningCloud
    browser: Browser
    grid: GridMap
    drive: Drive
    token: str
    sent: list[dict[str, object]] = field(default_factory=list)

    @property
    def pose(self) -> Pose2D:
        """The robot's true pose."""
        return self.drive.world.robots[0].base.pose

    def listen(self, page: Page) -> None:
        """Record the frames that the page sends to robots."""
        self.sent.clear()

        def opened(socket: WebSocket) -> None:
            socket.on("framesent", lambda frame: self.sent.append(json.loads(frame)))

        page.on("websocket", opened)

    def frames(self, op: str, topic: str) -> list[dict[str, object]]:
        """Return the frames of one kind that the page sent."""
        return [frame for frame in self.sent if (frame["op"], frame.get("topic")) == (op, topic)]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def scene(cloud: RunningCloud, office_map: GridMap) -> AsyncIterator[Scene]:
    """Return a browser beside a robot that is connected."""
    async with browsing() as browser:
        admin, rest = await cloud.admin(), RestClient(cloud.url)
        await admin.post("/v1/users", {"id": "dora", "password": ADMIN_PASSWORD, "role": "admin"})
        await rest.login("dora", ADMIN_PASSWORD)
        grid = GridMap(office_map.data, replace(office_map.info, origin=Pose2D(-3.0, 2.0, 0.4)))
        await publish_map(rest, "turned", grid)
        start = free_pose(grid, seed=1)
        token = await register_robot(rest, "tb-web", "turned", start)
        await rest.put_robot("tb-away", RobotFile(map="turned"))
        async with driving(cloud.url, token, "tb-web", grid, start) as drive:
            await until(lambda: drive.poses)
            yield Scene(cloud, browser, grid, drive, token)


@pytest_asyncio.fixture(loop_scope="module")
async def context(scene: Scene) -> AsyncIterator[BrowserContext]:
    """Return a browser context without data of other tests."""
    fresh = await scene.browser.new_context(viewport=DESK)
    yield fresh
    await fresh.close()


async def test_a_wrong_password_is_refused_and_the_right_one_logs_in(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, GONE) as page:
        await page.goto(scene.cloud.url)
        await page.get_by_label("User").fill("dora")
        await page.get_by_label("Password").fill("no such password")
        await page.get_by_role("button", name="Log in").click()
        await expect(page.get_by_role("alert").first).to_have_text("This user and password do not go together.")
        await page.get_by_label("Password").fill(ADMIN_PASSWORD)
        await page.keyboard.press("Enter")
        await expect(page.locator("#user")).to_have_text("dora")
        assert page.url == f"{scene.cloud.url}/dashboard/", "neither password nor token is in the address"
        await page.reload()
        await expect(page.locator("#user")).to_have_text("dora")
        await page.get_by_role("button", name="Log out").click()
        await expect(page.get_by_role("button", name="Log in")).to_be_visible()
        assert await page.evaluate("sessionStorage.getItem('ppaas-token')") is None


async def test_map_and_robots_are_shown_at_their_positions(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, READ_BACK) as page:
        await enter(page, scene.cloud.url, scene.token)
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("online")
        await expect(page.get_by_role("button", name="tb-away")).to_contain_text("offline")
        await expect(page.locator("#map-choice")).to_have_value("turned")
        eye = await Eye.on(page, scene.grid.info)
        await page.locator("label", has_text="Laser scans").click()
        wall = scene.grid.info.origin @ Pose2D(0.03, 1.0, 0.0)
        await expect_colour(page, eye.see(wall), "#37445a")
        await expect_colour(page, eye.corner, "#e9edf3")
        body = scene.pose @ Pose2D(-0.13, 0.0, 0.0)
        await expect_colour(page, eye.see(body), await variable(page, "--robot-1"))


async def test_dragging_on_the_map_sends_the_robot_to_that_pose(scene: Scene, context: BrowserContext) -> None:
    places = [reachable_pose(scene.grid, scene.pose, seed=seed, at_least=1.5) for seed in range(20)]
    goal = min(places, key=scene.pose.distance_to)
    async with looking(context) as page:
        await enter(page, scene.cloud.url, scene.token)
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("online")
        eye = await Eye.on(page, scene.grid.info)
        await page.mouse.click(*eye.see(scene.pose))
        await expect(page.locator("#tool-drive")).to_have_attribute("aria-pressed", "true")
        ahead = goal @ Pose2D(1.0, 0.0, 0.0)
        await page.mouse.move(*eye.see(goal))
        await page.mouse.down()
        await page.mouse.move(*eye.see(ahead), steps=4)
        await page.mouse.up()
        await expect(page.locator("#robot-card .doing")).to_have_text(re.compile(r"Driving, \d+\.\d m to go"))
        await expect(page.locator(".toast")).to_contain_text("tb-web arrived", timeout=60_000)
        assert scene.pose.distance_to(goal) <= 0.3
        assert abs((scene.pose.theta - goal.theta + 3.1416) % 6.2832 - 3.1416) < 0.4


async def test_a_goal_is_cancelled_and_given_by_keyboard(scene: Scene, context: BrowserContext) -> None:
    goal = reachable_pose(scene.grid, scene.pose, seed=3, at_least=4.0)
    async with looking(context) as page:
        await enter(page, scene.cloud.url, scene.token)
        await page.get_by_role("button", name="tb-web").press("Enter")
        await page.get_by_text("Drive to coordinates").press("Enter")
        await page.get_by_label("x [m]").fill(f"{goal.x:.2f}")
        await page.get_by_label("y [m]").fill(f"{goal.y:.2f}")
        await page.keyboard.press("Enter")
        await expect(page.get_by_role("button", name="Cancel goal")).to_be_enabled()
        await until(lambda: scene.drive.commands[-1][1].linear.x > 0.0)
        await page.get_by_role("button", name="Cancel goal").press("Enter")
        await expect(page.locator(".toast").last).to_contain_text("tb-web stopped")
        await until(lambda: scene.drive.commands[-1][1].linear.x == 0.0)
        assert scene.pose.distance_to(goal) > 1.0
        await page.locator("#map").press("Escape")
        await expect(page.locator("#robot-card")).to_be_hidden()


async def test_what_is_wrong_with_a_robot_is_said_in_words(scene: Scene, context: BrowserContext) -> None:
    async with looking(context) as page:
        await enter(page, scene.cloud.url, scene.token)
        await page.get_by_role("button", name="tb-away").press("Enter")
        await page.get_by_text("What is wrong?").press("Enter")
        finding = page.locator(".finding")
        await expect(finding).to_contain_text(["Error: Robot 'tb-away' is not connected."])
        await expect(finding).to_contain_text(["Start its program"])
        await expect(page.locator(".topics li")).to_have_count(0)
        await page.get_by_role("button", name="tb-web").press("Enter")
        await expect(page.locator(".topics li").first).to_contain_text("scan")
        await expect(finding.first).not_to_contain_text("tb-away")


async def test_pictures_of_a_camera_are_asked_for_while_they_are_shown(scene: Scene, context: BrowserContext) -> None:
    camera, stop = "camera/image/compressed", asyncio.Event()
    filming = asyncio.create_task(film(scene, camera, stop))
    async with looking(context, READ_BACK) as page:
        scene.listen(page)
        await enter(page, scene.cloud.url, scene.token)
        await page.get_by_role("button", name="tb-web").press("Enter")
        assert not scene.frames("subscribe", camera)
        await page.get_by_text("Camera", exact=True).press("Enter")
        picture = page.get_by_role("img", name=f"Picture of {camera} of tb-web")
        await expect(picture).to_be_visible()
        seen = "one => [one.width, one.height, ...one.getContext('2d').getImageData(9, 9, 1, 1).data]"
        assert await picture.evaluate(seen) == [640, 320, 255, 0, 0, 255]
        [asked] = scene.frames("subscribe", camera)
        assert asked["throttle_rate"] == 500
        async with page.expect_event("websocket") as again:
            await page.get_by_text("Camera", exact=True).press("Enter")
            await expect(picture).to_be_hidden()
            await page.get_by_text("Camera", exact=True).press("Enter")
        assert "ticket=" in (await again.value).url
        stop.set()
        await filming


async def film(scene: Scene, topic: str, stop: asyncio.Event) -> None:
    """Publish red pictures by a plain rosbridge client, until told to stop."""
    file = io.BytesIO()
    Image.new("RGB", (1280, 640), "red").save(file, "png")
    picture = {"format": "png", "data": base64.b64encode(file.getvalue()).decode()}
    url = f"{scene.cloud.url.replace('http', 'ws', 1)}/?robot=tb-web&role=operator"
    async with connect(url, additional_headers={"Authorization": f"Bearer {scene.token}"}) as socket:
        await socket.send(json.dumps({"op": "advertise", "topic": topic, "type": "sensor_msgs/CompressedImage"}))
        while not stop.is_set():
            await socket.send(json.dumps({"op": "publish", "topic": topic, "msg": picture}))
            await asyncio.sleep(0.1)


async def test_a_robot_is_recorded_and_its_file_downloaded(scene: Scene, context: BrowserContext) -> None:
    async with looking(context) as page:
        await enter(page, scene.cloud.url, scene.token)
        await page.get_by_role("button", name="tb-web").press("Enter")
        await page.get_by_role("button", name="Recordings").press("Enter")
        dialog = page.get_by_role("dialog", name="Recordings of tb-web")
        await dialog.get_by_role("button", name="Start recording").click()
        await expect(dialog.get_by_role("status")).to_contain_text("Recording, ends by itself in 60 minutes")
        await dialog.get_by_role("button", name="Stop recording").click()
        await expect(dialog.get_by_role("button", name="Start recording")).to_be_enabled()
        async with page.expect_download() as download:
            await dialog.get_by_role("button", name=re.compile("^Download 20")).click()
        file = await (await download.value).path()
        assert file.read_bytes().startswith(b"\x89MCAP")
        page.once("dialog", lambda question: question.accept())
        await dialog.get_by_role("button", name="Delete").click()
        await expect(dialog.get_by_role("listitem")).to_have_count(0)
        await page.keyboard.press("Escape")
        await expect(dialog).to_be_hidden()


async def test_a_layer_that_is_switched_off_is_unsubscribed(scene: Scene, context: BrowserContext) -> None:
    async with looking(context) as page:
        scene.listen(page)
        await enter(page, scene.cloud.url, scene.token)
        await until(lambda: scene.frames("subscribe", "scan"))
        for name, topic in (("Laser scans", "scan"), ("Paths", "plan"), ("Particles", "particlecloud")):
            assert scene.frames("subscribe", topic)[0]["throttle_rate"]
            await page.get_by_label(name).uncheck()
            await until(lambda topic=topic: scene.frames("unsubscribe", topic))
            await page.get_by_label(name).check()
            await until(lambda topic=topic: len(scene.frames("subscribe", topic)) == 2)


async def test_the_pose_of_the_robot_can_be_set(scene: Scene, context: BrowserContext) -> None:
    async with looking(context) as page:
        scene.listen(page)
        await enter(page, scene.cloud.url, scene.token)
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("online")
        eye = await Eye.on(page, scene.grid.info)
        await page.get_by_role("button", name="tb-web").click()
        await page.get_by_role("button", name="Set pose").click()
        ahead = scene.pose @ Pose2D(1.0, 0.0, 0.0)
        await page.mouse.move(*eye.see(scene.pose))
        await page.mouse.down()
        await page.mouse.move(*eye.see(ahead), steps=3)
        await page.mouse.up()
        await until(lambda: scene.frames("publish", "initialpose"))
        await expect(page.locator(".toast")).to_have_text("tb-web was told where it is")
        await until(lambda: scene.drive.estimate().distance_to(scene.pose) < 0.2)


async def test_machines_and_containers_show_their_load(scene: Scene, context: BrowserContext) -> None:
    async with looking(context) as page:
        await enter(page, scene.cloud.url, scene.token)
        machine = page.locator("#machines > li")
        await expect(machine).to_have_count(1)
        await expect(machine).to_contain_text(re.compile(r"\d+ containers?"))
        await expect(machine).to_contain_text(re.compile(r"CPU\d+\.\d of \d+ cores?"))
        await expect(machine).to_contain_text(re.compile(r"Memory\d+(\.\d)? GiB of \d+"))
        endpoint = page.locator("#endpoints > li")
        await expect(endpoint).to_have_count(1)
        await expect(endpoint).to_contain_text(re.compile(r"local-1[1-9]\d* sockets · \d+ frames/s"))
        container = page.locator("#containers > li", has_text="dora / tb-web")
        await expect(container).to_contain_text(re.compile(r"PSS\d+(\.\d)? MiB"))
        shares = await page.get_by_role("meter").evaluate_all("all => all.map((one) => one.ariaValueNow)")
        assert all(0 <= int(share) <= 100 for share in shares) and len(shares) >= 4


async def test_people_are_shown_named_and_chosen(context: BrowserContext) -> None:
    async with serving_people() as (url, token, store), looking(context) as page:

        def settings() -> PeopleSettings:
            return store.map_people("ann", "house").settings

        await enter(page, url, token)
        first, second = page.locator("#people > li").first, page.locator("#people > li").last
        await expect(first).to_contain_text("Followed by tb1: nearest; seen as tb1/4")
        await expect(second).to_contain_text("hidden")
        await second.locator(".robot").click()
        await second.get_by_role("button", name="Follow").click()
        await expect(second.get_by_role("button", name="Do not follow")).to_be_visible()
        assert (settings().rule, settings().targets) == ("named", [2])
        await second.get_by_text("Name", exact=True).first.click()
        await second.get_by_label("Name", exact=True).fill("<b>Zoë</b>")
        await second.get_by_role("button", name="Name").click()
        await expect(page.locator(".toast").last).to_have_text("Changed")
        assert settings().names == {"2": "<b>Zoë</b>"}
        await page.get_by_text("Whom robots follow").click()
        await page.get_by_label("Rule").select_option("longest_seen")
        await page.get_by_label("Count people by hour").check()
        await until(lambda: (settings().rule, settings().history) == ("longest_seen", True))


async def test_the_dashboard_is_usable_by_touch_on_a_phone(scene: Scene) -> None:
    context = await scene.browser.new_context(viewport=PHONE, has_touch=True, device_scale_factor=2)
    async with looking(context) as page:
        scene.listen(page)
        await enter(page, scene.cloud.url, scene.token)
        for panel in ("Load", "Layers", "Robots"):
            await page.get_by_role("button", name=panel, exact=True).tap()
            assert await too_small(page) == []
        await page.get_by_role("button", name="tb-web").tap()
        await expect(page.locator("#robot-card")).to_be_visible()
        assert await too_small(page) == []
        await page.get_by_role("button", name="Recordings").tap()
        await expect(page.get_by_role("button", name="Start recording")).to_be_enabled()
        assert await too_small(page) == []
        await page.get_by_role("button", name="Close").tap()
        assert await page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        eye = await Eye.on(page, scene.grid.info)
        goal = reachable_pose(scene.grid, scene.pose, seed=5, at_least=1.0)
        await page.touchscreen.tap(*eye.see(goal))
        await until(lambda: scene.frames("publish", "move_base/goal"))
        await page.get_by_role("button", name="Cancel goal").tap()
        await until(lambda: scene.frames("publish", "move_base/cancel"))
    await context.close()


async def test_names_are_never_rendered_as_html(scene: Scene, context: BrowserContext) -> None:
    name = "<img src=x onerror=alert(1)><b>bold"

    async def rename(route: Route) -> None:
        answer = await route.fetch()
        await route.fulfill(response=answer, body=(await answer.text()).replace("tb-web", name))

    await context.route("**/v1/robots*", rename)
    await context.route("**/v1/containers*", rename)
    async with looking(context, rf"{GONE}|TrustedHTML") as page:
        dialogs: list[Dialog] = []
        page.on("dialog", lambda dialog: dialogs.append(dialog))  # noqa: PLW0108 - Playwright marks its listeners
        await enter(page, scene.cloud.url, scene.token)
        await page.locator("#robots .name", has_text=name).click()
        await expect(page.locator("#robot-card .name")).to_have_text(name)
        await expect(page.locator("#containers .name", has_text=name)).to_have_text(f"dora / {name}")
        assert await page.locator("img[src=x], b").count() == 0
        with pytest.raises(Exception, match="TrustedHTML"):
            await page.evaluate("document.body.innerHTML = '<b>bold'")
        assert dialogs == []


async def test_an_expired_login_asks_to_log_in_again(scene: Scene, context: BrowserContext) -> None:
    async with looking(context, GONE) as page:
        await enter(page, scene.cloud.url, "expired")
        await expect(page.locator("#login-error")).to_have_text("Your login has expired: log in again.")
        assert await page.evaluate("sessionStorage.getItem('ppaas-token')") is None


async def test_the_dashboard_reconnects_after_the_cloud_was_unreachable(scene: Scene, context: BrowserContext) -> None:
    async with Forwarder(scene.cloud.url) as network, looking(context, GONE) as page:
        await enter(page, network.url, scene.token)
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("online")
        await network.cut()
        await expect(page.locator("#banner")).to_have_text("The cloud does not answer. Trying again…")
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("no signal")
        await network.mend()
        await expect(page.locator("#banner")).to_be_hidden()
        await expect(page.get_by_role("button", name="tb-web")).to_contain_text("online")


async def test_users_without_maps_or_robots_see_which_commands_to_type(scene: Scene, context: BrowserContext) -> None:
    admin, rest = await scene.cloud.admin(), RestClient(scene.cloud.url)
    await admin.post("/v1/users", {"id": "newcomer", "password": ADMIN_PASSWORD})
    token = (await rest.login("newcomer", ADMIN_PASSWORD)).token
    async with looking(context) as page:
        await enter(page, scene.cloud.url, token)
        await expect(page.locator("#empty-stage")).to_contain_text("ppaas map publish")
        await expect(page.locator("#no-machines")).to_contain_text("Administrators")
        await expect(page.locator("#endpoints-load")).to_be_hidden()
        await publish_map(rest, "first", scene.grid)
        await expect(page.locator("#no-robots")).to_contain_text("ppaas robot put")
        await expect(page.locator("#empty-stage")).to_be_hidden()


async def test_a_robot_is_shown_to_users_with_whom_it_is_shared(scene: Scene, context: BrowserContext) -> None:
    admin, rest = await scene.cloud.admin(), RestClient(scene.cloud.url)
    await admin.post("/v1/users", {"id": "guest", "password": ADMIN_PASSWORD, "groups": ["hall"]})
    await admin.put("/v1/robots/dora:tb-web/shares/group:hall", {"role": "look"})
    token = (await rest.login("guest", ADMIN_PASSWORD)).token
    async with looking(context) as page:
        await enter(page, scene.cloud.url, token)
        await expect(page.locator("#map-choice")).to_have_value("turned")
        await expect(page.get_by_role("button", name="dora:tb-web")).to_contain_text("online")
        await page.get_by_role("button", name="dora:tb-web").press("Enter")
        await expect(page.locator("#hint")).to_have_text("You may look at dora:tb-web, not drive it")
        for tool in ("drive", "locate"):
            await expect(page.locator(f"#tool-{tool}")).to_be_disabled()
        await expect(page.get_by_text("Drive to coordinates")).to_be_hidden()
        await expect(page.get_by_role("button", name="Cancel goal")).to_be_hidden()
        await page.get_by_role("button", name="Recordings").press("Enter")
        await expect(page.get_by_role("dialog").get_by_role("status")).to_contain_text("Not recording")
        await expect(page.get_by_role("button", name="Start recording")).to_be_disabled()
        await page.get_by_role("button", name="Close").press("Enter")
        await admin.put("/v1/robots/dora:tb-web/shares/group:hall", {"role": "drive"})
        for tool in ("drive", "locate"):
            await expect(page.locator(f"#tool-{tool}")).to_be_enabled()
        await expect(page.get_by_text("Drive to coordinates")).to_be_visible()
        await expect(page.get_by_role("button", name="Cancel goal")).to_be_visible()
        await admin.delete("/v1/robots/dora:tb-web/shares/group:hall")
        await expect(page.get_by_role("button", name="dora:tb-web")).to_be_hidden()


# -- looks -------------------------------------------------------------------------------------------------------------


async def variable(page: Page, name: str) -> str:
    """Return a colour of the page's style."""
    return str(await page.evaluate(f"getComputedStyle(document.documentElement).getPropertyValue('{name}').trim()"))


async def expect_colour(page: Page, at: tuple[float, float], colour: str) -> None:
    """Wait until the map has a colour at a position of the page."""
    script = """([x, y]) => {
        const map = document.getElementById("map"), box = map.getBoundingClientRect();
        const pixel = map.getContext("2d").getImageData(Math.round(x - box.left), Math.round(y - box.top), 1, 1).data;
        return "#" + [...pixel.slice(0, 3)].map((part) => part.toString(16).padStart(2, "0")).join("");
    }"""
    for _ in range(50):
        if (seen := await page.evaluate(script, list(at))) == colour:
            return
        await page.evaluate("new Promise(requestAnimationFrame)")
    assert seen == colour


async def too_small(page: Page) -> list[str]:
    """Return the visible controls that are smaller than a thumb."""
    script = f"""() => [...document.querySelectorAll("button, select, input, label.switch, summary")]
        .filter((one) => one.checkVisibility() && !one.closest("label.switch input"))
        .map((one) => [one, (one.closest("label.switch") ?? one).getBoundingClientRect()])
        .filter(([, box]) => Math.min(box.width, box.height) < {TOUCH})
        .map(([one, box]) => `${{one.outerHTML.slice(0, 60)}} ${{box.width}}×${{box.height}}`)"""
    return list(await page.evaluate(script))


async def test_the_api_documentation_loads_nothing_from_other_hosts(scene: Scene, context: BrowserContext) -> None:
    requests: list[str] = []
    async with looking(context) as page:
        page.on("request", lambda request: requests.append(request.url))
        await page.goto(f"{scene.cloud.url}/docs")
        await expect(page.get_by_role("heading", name=re.compile("PPaaS"))).to_be_visible()
        await expect(page.get_by_text("/v1/plans", exact=True).first).to_be_visible()
    assert len(requests) >= 4, requests
    assert [url for url in requests if not url.startswith((scene.cloud.url, "data:"))] == []

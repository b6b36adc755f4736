"""Takes pictures of all pages of the dashboard, on a desk and on a phone, in light and dark.

``python -m benchmarks.service.dashboard_pictures FOLDER [--docs]``. The REST service is the cloud's own, with records
of all kinds; the robots are made up, and their WebSockets are answered here. With ``--docs``, only the pictures of the
documentation are taken, in light.
"""

import argparse
import asyncio
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from playwright.async_api import Browser, BrowserContext, Page, ViewportSize, expect
from starlette.types import ASGIApp

from benchmarks.service.dashboard_under_load import example_zones
from endpoints.audit.event import AuditEvent
from endpoints.resources.services import Services
from engine.control.buildings.views import BuildingView, DoorView, LiftView, RideView
from engine.control.journeys.views import JourneyView, SiteView
from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings
from ppaas.clock import epoch
from ppaas.geometry import poses_along
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import OCCUPIED
from ppaas.tasks.records import Task
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.records import MapTask, ProposedChange
from tests.support.cloud.browser import PHONE, Eye, browsing, enter
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.fleet import RobotSockets, serving_fleet
from tests.support.endpoints.traffic import add_traffic
from tests.support.endpoints.zones import GRID
from tests.support.recordings.kept import kept_recordings
from tests.support.storage.records import GivenMap, plan, propose, put_map, token, user

ROBOTS, CONNECTED = 12, 10
DESK = ViewportSize(width=1440, height=900)
Scheme = Literal["light", "dark"]
LOOKS: Sequence[tuple[str, ViewportSize, Scheme]] = (
    ("desk", DESK, "light"),
    ("desk-dark", DESK, "dark"),
    ("phone", ViewportSize(width=PHONE["width"], height=PHONE["height"]), "light"),
    ("phone-dark", ViewportSize(width=PHONE["width"], height=PHONE["height"]), "dark"),
)
DOCS = {"desk-tasks": "tasks", "desk-building": "building-map", "desk-buildings": "building-record"}
"""Pictures of the documentation, by their names here."""

PLACES = ((2.0, 3.0), (7.5, 3.2), (12.0, 7.9), (3.0, 8.0), (17.0, 8.2), (20.5, 3.4), (11.5, 13.0), (16.4, 12.4))
"""Places where robots stand [m]."""

CARS = {"north": (7.0, 13.0), "south": (20.6, 12.8)}
"""Lower left corners of the cars of lifts [m]."""

PARTS_OF_FLOOR = ZoneSet(
    [
        zone
        for lift, (x, y) in CARS.items()
        for zone in (
            Zone(
                Polygon([[[x, y], [x + 1.6, y], [x + 1.6, y + 1.8], [x, y + 1.8], [x, y]]]),
                LiftCar(name=f"car of {lift}", lift=lift),
            ),
            Zone(LineString([[x + 0.2, y - 0.1], [x + 1.4, y - 0.1]]), Door(name=f"landing of {lift}", lift=lift)),
        )
    ]
    + [Zone(LineString([[7.0, 7.2], [7.0, 8.6]]), Door(name="gate"))]
)

SHUTTER = 1.2
"""Time until what was opened has been drawn [s]."""


@dataclass(frozen=True, slots=True)
class Photographer:
    """Takes pictures of a page."""

    page: Page
    sockets: RobotSockets
    folder: Path
    look: str
    only: frozenset[str]

    @property
    def is_phone(self) -> bool:
        """Whether the page has the size of a phone's screen."""
        return self.look.startswith("phone")

    async def take(self, name: str) -> None:
        """Write a picture of what is shown."""
        whole = f"{self.look}-{name}"
        if self.only and whole not in self.only:
            return
        await asyncio.sleep(SHUTTER)
        await self.page.screenshot(path=self.folder / f"{DOCS[whole] if self.only else whole}.png")

    async def open(self, title: str) -> None:
        """Open a page."""
        await self.page.get_by_role("navigation", name="Pages").get_by_role("link", name=title).click()
        await expect(self.page.locator("#page h2")).to_have_text(title)

    async def panel(self, name: str) -> None:
        """Open a panel; on a desk it is open."""
        if self.is_phone and not await self.page.locator(f"#panel-{name}").is_visible():
            await self.page.locator(f".tab[data-panel={name}]").click()


# -- records of all kinds ----------------------------------------------------------------------------------------------


def fill(services: Services) -> None:
    """Add tasks, events, plans, users, tokens, a recording, versions of the map and one that waits for a review."""
    store, now = services.store, epoch()
    for task in example_tasks(now):
        store.put_task(MapTask("ann", "office", task))
    for event in example_events(now):
        services.audit.record(event)
    ends = np.array([[2.0, 3.0], [12.0, 7.9], [20.5, 3.4], [3.0, 8.0]])
    for number in range(12):
        line = np.linspace(ends[number % 4], ends[(number + 1) % 4], 60)
        poses = poses_along(line, 0.0).astype("<f8").tobytes()
        kept = {"map": "office", "planner": ("astar", "theta_star")[number % 2], "created": now - 300.0 * number}
        store.add_plan(plan(f"p{number}", poses=poses, start=(*ends[number % 4], 0.0), **kept))
    for name, role in (("bob", "user"), ("carla", "admin"), ("dieter-from-the-night-shift", "user")):
        store.add_user(user(name, role=role, groups=("hall",) if role == "user" else ()))
    store.add_token(token("f" * 64, user="ann", expires=now + 9e5, created=now - 4e4, name="display in the hall"))
    for number, (left, row) in enumerate(((150, 30), (250, 150)), 1):
        cells = GRID.data.copy()
        cells[row : row + 6, left : left + 30] = OCCUPIED
        yaml, image = save_map(replace(GRID, data=cells), "office.pgm")
        changed = GivenMap("office", "ann", yaml, image, created=now - 7200.0 / number)
        if number == 1:
            put_map(services.map_store, changed, message="The shelf at the dock was moved")
            yaml, image = save_map(GRID, "office.pgm")
            put_map(
                services.map_store,
                GivenMap("office", "ann", yaml, image, zones=geojson_of(PARTS_OF_FLOOR), created=now - 3600.0),
            )
        else:
            pallet = ProposedChange(occupied=180, rectangles=((left, row, 30, 6),))
            propose(
                services.map_store,
                changed,
                change=pallet,
                message="A pallet stands in the corridor",
                created=now - 600.0,
            )


def add_building(services: Services) -> None:
    """Add a building of two floors with two lifts, of which one is out of order, a door, and journeys."""
    yaml, image = save_map(GRID, "attic.pgm")
    put_map(services.map_store, GivenMap("attic", "ann", yaml, image, zones=geojson_of(PARTS_OF_FLOOR)))
    made = Building(
        floors=(Floor(name="L1", map="office"), Floor(name="L2", map="attic", elevation=3.6)),
        lifts=(
            LiftSettings(lift="north", robots=2, speed=1.2, device="http://10.0.0.7/north"),
            LiftSettings(lift="south", wait=35.0, device="modbus://10.0.0.8/1"),
        ),
        doors=(DoorSettings(floor="L1", door="gate", device="http://10.0.0.7/gate"),),
    )
    version = BuildingVersion(number=4, building=made, author="ann", created=epoch(), message="as measured")
    services.store.put_building(BuildingRecord(user="ann", id="hotel", present=version, readers=("bob",)))
    rides = [
        RideView("ann/tb2", "L2", "L1", "inside", epoch() - 40.0),
        RideView("ann/tb4", "L1", "L2", "waiting", epoch() - 25.0),
    ]
    lifts = [
        LiftView("north", "", "L1", "L1", "open", "stopped", "agv", "ppaas/ann/hotel/north", rides),
        LiftView(
            "south", "lift 'south' is in the mode 'fire'", "L2", "", "open", "stopped", "fire", "", [], serves=False
        ),
    ]
    now = epoch()
    rows: list[tuple[Any, ...]] = [
        ("tb7", "L1", "L1", "driving", "", "succeeded", "", now - 300.0, now - 120.0),
        ("tb2", "L2", "L1", "inside", "north", "active", "", now - 95.0),
        ("tb4", "L1", "L2", "waiting", "north", "active", "", now - 25.0),
    ]
    journeys = [JourneyView(f"journey-{number}", "ann", *row) for number, row in enumerate(rows)]
    services.journeys = led = FakeJourneys()
    led.state = SiteView(BuildingView(lifts, [DoorView("L1", "gate", "open", ["ann/tb5"])], []), journeys)


def example_tasks(now: float) -> list[Task]:
    """Return tasks in each state."""

    def task(name: str, state: str, **fields: Any) -> Task:
        given: dict[str, Any] = {"kind": "go_to", "places": ((2.0, 3.0, 0.0),), "created": now - 900.0}
        return Task(id=name, state=state, **(given | fields))  # type: ignore[arg-type]  # states as words

    two = ((2.0, 3.0, 0.0), (12.0, 7.9, 1.57))
    begun = {"assigned": now - 400.0, "begun": now - 250.0}
    ended = begun | {"ended": now - 120.0}
    return [
        task("t1", "queued", priority=5, labels={"lift": "yes"}, deadline=now + 1500.0),
        task("t2", "queued", kind="pick_drop", places=two, created=now - 60.0),
        task("t3", "assigned", kind="pick_drop", places=two, robot="tb1", assigned=now - 20.0),
        task("t4", "active", kind="patrol", places=(*two, two[0]), rounds=4, robot="tb2", leg=5, **begun),
        task("t5", "active", robot="tb3", **begun),
        task("t6", "done", robot="tb1", **ended),
        task("t7", "done", kind="pick_drop", places=two, robot="tb4", **ended),
        task("t8", "failed", robot="tb5", failures=3, reason="no robot reached it: the way is blocked", **ended),
        task("t9", "cancelled", **ended),
    ]


def example_events(now: float) -> list[AuditEvent]:
    """Return an hour of events: logins, connections, changes and refusals."""

    def event(age: float, action: str, **fields: Any) -> AuditEvent:
        given: dict[str, Any] = {"time": now - age, "user": "ann", "address": "10.0.0.7", "action": action}
        return AuditEvent(**(given | fields))

    events = [event(3500.0, "log_in", object="users/ann"), event(3400.0, "publish_map", object="maps/office")]
    for number in range(CONNECTED):
        name, role = f"robots/tb{number}", {"role": "robot"}
        events.append(event(3000.0 - 20.0 * number, "connect", object=name, details=role))
        events.append(event(900.0 - 40.0 * number, "connect", object=name, details={"role": "operator"}))
    lost = {"role": "robot", "code": 1006, "seconds": 2400.5}
    events += [
        event(500.0, "disconnect", object="robots/tb11", details=lost),
        event(
            450.0, "log_in", user="bob", object="users/bob", outcome="refused", status=401, reason="not-authenticated"
        ),
        event(300.0, "change_robot", object="robots/tb3", details={"cores": 0.5}),
        event(200.0, "put_robot", user="bob", outcome="refused", status=403, reason="not-permitted", object="robots/x"),
        event(100.0, "create_token", details={"name": "display in the hall", "robots": ["tb*"], "role": "look"}),
    ]
    return sorted(events, key=lambda one: one.time)


# -- the pictures ------------------------------------------------------------------------------------------------------


async def take_map(scene: Photographer) -> None:
    """Take the map with its panels, the cards of robots, a zone, and the table of the fleet."""
    page, robots = scene.page, scene.page.locator("#robots .robot")
    await scene.take("map")
    for panel in ("robots", "load", "layers"):
        if scene.is_phone:
            await scene.panel(panel)
            await scene.take(f"panel-{panel}")
    for number, name in ((1, "card-failed"), (3, "card-drives"), (11, "card-offline")):
        await scene.panel("robots")
        await robots.nth(number).click()
        await scene.take(name)
    await page.locator("#robot-card").get_by_text("What is wrong?").click()
    await scene.take("card-doctor")
    await page.locator("#robot-card").get_by_role("button", name="Done").click()
    await scene.panel("robots")
    await page.locator("#zones").get_by_role("button", name="workshop").click()
    await page.locator("#panel-zones").scroll_into_view_if_needed()
    await scene.take("zone")
    await page.locator("#zones").get_by_role("button", name="workshop").click()
    await page.get_by_role("button", name="Fleet").click()
    await scene.take("fleet")
    await page.get_by_role("dialog", name="Fleet").get_by_role("button", name="Close").click()


async def take_building(scene: Photographer) -> None:
    """Take the map with the lifts and doors of its building, and their panel."""
    await scene.panel("robots")
    await scene.page.locator("#panel-building").evaluate("(panel) => panel.scrollIntoView()")
    await scene.take("building")


async def take_pages(scene: Photographer) -> None:
    """Take each page, and each with its forms open."""
    page = scene.page
    for link in await page.get_by_role("navigation", name="Pages").get_by_role("link").all():
        title = (await link.locator("span").first.inner_text()).strip()
        if title == "Map":
            continue
        await scene.open(title)
        await scene.take(title.lower())
        forms = page.locator("#page .page-parts > .go > summary:visible, #page section > .go > summary:visible")
        for form in await forms.all():
            await form.click()
        if await forms.count():
            await scene.take(f"{title.lower()}-forms")


async def take_picking(scene: Photographer) -> None:
    """Take the map while places of a task are picked on it."""
    page = scene.page
    await scene.open("Tasks")
    if not await page.get_by_role("form", name="Add a task").is_visible():
        await page.get_by_text("Add a task").first.click()
    await page.get_by_label("What").select_option("patrol")
    await page.get_by_role("button", name="Pick on the map").click()
    await page.locator("#map").press(" ")
    await scene.take("picking")
    await page.get_by_role("button", name="Cancel", exact=True).click()


async def take_token_and_stop(scene: Photographer) -> None:
    """Take the dialog with a new token, and the page while all robots are stopped."""
    page = scene.page
    await scene.open("Robots")
    await page.get_by_role("button", name="New token for tb0").click()
    await scene.take("token")
    await page.keyboard.press("Escape")
    await page.get_by_role("link", name="Map", exact=True).click()
    await page.get_by_role("button", name="STOP ALL").click()
    await expect(page.locator("#stopped")).to_contain_text("All robots are stopped")
    await scene.take("stopped")
    await page.locator("#stopped").get_by_role("button", name="Release…").click()
    await scene.take("release")
    await page.get_by_role("button", name="Release", exact=True).click()


PARTS: Sequence[Callable[[Photographer], Awaitable[None]]] = (
    take_map, take_building, take_pages, take_picking, take_token_and_stop,
)  # fmt: skip


@asynccontextmanager
async def serving() -> AsyncIterator[tuple[str, str]]:
    """Serve the fleet; return the URL and the token of its owner."""

    def filled(app: ASGIApp) -> ASGIApp:
        services: Services = app.state.services  # type: ignore[attr-defined]  # of FastAPI
        fill(services)
        add_building(services)
        object.__setattr__(services, "recordings", kept_recordings(services.cloud, "ann", "tb1"))  # type: ignore[arg-type]
        return app

    async with serving_fleet(ROBOTS, lambda number: number < CONNECTED, around=filled) as (url, owner, cloud):
        add_traffic(cloud, "ann", "office")
        yield url, owner


async def shown(context: BrowserContext, url: str, owner: str, sockets: RobotSockets) -> Page:
    """Open the dashboard, with robots of which one has failed."""
    page = await context.new_page()
    await sockets.answer(page)
    await example_zones().answer(page)
    await enter(page, url, owner)
    await expect(page.locator("#robots > li")).to_have_count(ROBOTS)
    for number, place in enumerate(PLACES):
        await expect(page.locator("#robots > li").nth(number)).to_contain_text("No pose of it comes")
        sockets.place(f"tb{number}", *place)
    sockets.status("tb1", 4, "There is no way to the goal: a pallet stands in the corridor behind the crossing")
    sockets.status("tb3", 1)
    await Eye.on(page, GRID.info)
    return page


async def take_login(browser: Browser, url: str, folder: Path, look: tuple[str, ViewportSize, Scheme]) -> None:
    """Take the form of the login."""
    name, size, scheme = look
    context = await browser.new_context(viewport=size, color_scheme=scheme)
    page = await context.new_page()
    await page.goto(f"{url}/dashboard/")
    await page.get_by_role("button", name="Log in").wait_for()
    await page.screenshot(path=folder / f"{name}-login.png")
    await context.close()


async def take_all(folder: Path, *, docs: bool) -> None:
    """Take the pictures of all pages, or the pictures in the documentation alone."""
    for name, size, scheme in LOOKS[:1] if docs else LOOKS:
        sockets = RobotSockets()
        async with serving() as (url, owner), sockets.beating(), browsing() as browser:
            if not docs:
                await take_login(browser, url, folder, (name, size, scheme))
            context = await browser.new_context(viewport=size, color_scheme=scheme, has_touch=name.startswith("phone"))
            page = await shown(context, url, owner, sockets)
            scene = Photographer(page, sockets, folder, name, frozenset(DOCS if docs else ()))
            for part in [take_building, take_pages] if docs else PARTS:
                await part(scene)
            await context.close()
        sys.stdout.write(f"{name}: done\n")


def main() -> None:
    """Read the arguments and run."""
    parser = argparse.ArgumentParser(description="take pictures of all pages of the dashboard")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--docs", action="store_true", help="only the pictures of the documentation")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    asyncio.run(take_all(arguments.folder, docs=arguments.docs))


if __name__ == "__main__":
    main()

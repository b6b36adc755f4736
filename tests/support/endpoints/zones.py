"""Zones of a map that a page shows, answered in place of the cloud, and a server of that map."""

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager, closing

import msgspec
from argon2 import PasswordHasher, profiles
from playwright.async_api import Page, Route

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.journeys.calls import JourneyCalls
from ppaas.errors import InvalidInput
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.generate import office
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.zone import NO_ZONES, ZoneSet
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.serving import serve
from tests.support.storage.records import GivenMap, put_map

GRID = office(seed=1, width=24.0, height=16.0)
"""The map that is served."""


class ZonesOfMap:
    """Zones of a map, which pages read and replace.

    Attributes
    ----------
    zones : ZoneSet
        The zones that the pages get.
    in_force : list of str
        Names of those that are in force.
    asked : list of dict
        Headers of the requests that replaced them, or wanted to.
    refusal : str
        Why the next request that replaces them is refused, if it is.
    """

    def __init__(self, zones: ZoneSet = NO_ZONES, in_force: Iterable[str] = ()) -> None:
        self.zones, self.in_force = zones, list(in_force)
        self.asked: list[dict[str, str]] = []
        self.refusal = ""
        self._version = 1

    @property
    def tag(self) -> str:
        """Tag of the zones."""
        return f'"v{self._version}"'

    def replace(self, zones: ZoneSet) -> None:
        """Replace the zones, as another client does."""
        self.zones = zones
        self._version += 1

    async def answer(self, page: Page) -> None:
        """Answer the requests of a page for the zones of any map."""
        await page.route("**/v1/maps/*/zones", self._answer)

    async def _answer(self, route: Route) -> None:
        if route.request.method == "PUT":
            await self._put(route)
            return
        body = {**msgspec.json.decode(geojson_of(self.zones)), "in_force": self.in_force}
        await route.fulfill(json=body, content_type="application/geo+json", headers={"ETag": self.tag})

    async def _put(self, route: Route) -> None:
        self.asked.append(await route.request.all_headers())
        if self.asked[-1].get("if-match") != self.tag:
            await _refuse(route, 409, "the map has changed since")
            return
        try:
            if self.refusal:
                raise InvalidInput(self.refusal)
            self.replace(zones_of(route.request.post_data or ""))
        except InvalidInput as error:
            self.refusal = ""
            await _refuse(route, 400, str(error))
        else:
            self.in_force = [zone.name for zone in self.zones.zones]
            await route.fulfill(json={"version": self.tag})


async def _refuse(route: Route, status: int, detail: str) -> None:
    await route.fulfill(status=status, json={"detail": detail}, content_type="application/problem+json")


@asynccontextmanager
async def serving_map(journeys: JourneyCalls | None = None) -> AsyncIterator[tuple[str, str, str]]:
    """Serve `GRID` as ann's map office, which bob may read; return the URL and the tokens of both."""
    store, maps = MemoryStore(), MemoryMapStore()
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    for user in ("ann", "bob"):
        await accounts.register(user, "correct horse", "user")
    yaml, image = save_map(GRID, "office.pgm")
    put_map(maps, GivenMap("office", "ann", yaml, image, readers=("bob",)))
    with closing(accounts):
        tokens = [await accounts.login(user, "correct horse") for user in ("ann", "bob")]
        async with serve(
            create_app(Services(store, maps, accounts, FakeCloud(), journeys=journeys or FakeJourneys()))
        ) as port:
            yield f"http://127.0.0.1:{port}", tokens[0], tokens[1]

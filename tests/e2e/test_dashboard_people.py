"""People in the dashboard, in a real browser."""

from collections.abc import AsyncIterator

import pytest
from argon2 import PasswordHasher, profiles
from playwright.async_api import expect

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.services.services import Services
from ppaas.people.settings import PeopleSettings
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.cloud.browser import browsing, enter, looking
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.people import add_group, person
from tests.support.endpoints.serving import serve
from tests.support.storage.records import house, put_map, robot
from tests.support.waiting import until

pytestmark = pytest.mark.journey

PASSWORD = "correct horse"


@pytest.fixture
async def services() -> AsyncIterator[Services]:
    """Return services of a cloud in which ann's robots see two people in the map house."""
    store, maps, cloud = MemoryStore(), MemoryMapStore(), FakeCloud()
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    await accounts.register("ann", PASSWORD, "user")
    put_map(maps, house())
    store.put_robot(robot("tb1", user="ann"))
    add_group(cloud, "ann", "house", person(1), person(2, x=0.0, state="predicted", seen_by=[]))
    yield Services(store, maps, accounts, cloud)
    accounts.close()


async def test_people_are_shown_named_and_chosen_in_the_dashboard(services: Services) -> None:
    def settings() -> PeopleSettings:
        return services.store.map_people("ann", "house").settings

    token = await services.accounts.login("ann", PASSWORD)
    async with serve(create_app(services)) as port, browsing() as browser, looking(await browser.new_context()) as page:
        await enter(page, f"http://127.0.0.1:{port}", token)
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

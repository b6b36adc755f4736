"""The documentation site: it is built without a warning, has all pages, and works in a browser as a cloud serves it."""

import re
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from docs.site.__main__ import MERMAID
from docs.site.build import build
from docs.site.pages import GENERATED, project_pages
from endpoints.accounts.accounts import Accounts
from endpoints.app import OPERATIONS, create_app
from endpoints.http.front_settings import FrontSettings
from endpoints.resources.services import Services
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.cloud.browser import DESK, PHONE, looking
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.serving import serve
from tests.support.sources import pyproject

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the site; a warning, a broken link or anchor of any page fails it."""
    folder = tmp_path_factory.mktemp("docs") / "site"
    build(folder, mermaid=MERMAID if MERMAID.exists() else None)
    return folder


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def address(site: Path) -> AsyncIterator[str]:
    """Return the address of the site at an endpoint."""
    store = MemoryStore()
    accounts = Accounts(store)
    app = create_app(Services(store, MemoryMapStore(), accounts, FakeCloud()), FrontSettings(docs_site=site))
    async with serve(app) as port:
        yield f"http://127.0.0.1:{port}/docs-site/"
    accounts.close()


async def test_each_page_of_the_project_is_in_the_site(site: Path) -> None:
    places = [*project_pages().values(), *GENERATED]
    assert len(places) > 100
    assert [place for place in places if not (site / f"{place}.html").is_file()] == []


async def test_the_reference_has_all_commands_and_operations(site: Path) -> None:
    commands = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    names = pyproject()["project"]["entry-points"]["ppaas.commands"]
    assert [name for name in names if f'id="ppaas-{name}"' not in commands] == []
    rest = (site / "reference" / "rest.html").read_text(encoding="utf-8")
    operations = [f"{method} {path}" for path, methods in OPERATIONS for method in methods]
    assert [each for each in operations if f">{each}</span>" not in re.sub(r"</span>\s*<span[^>]*>", " ", rest)] == []


async def test_a_reader_finds_a_page_by_the_search(address: str, browser: Browser) -> None:
    context = await browser.new_context(viewport=DESK)
    async with looking(context) as page:
        await page.goto(address)
        await page.get_by_placeholder("Search").first.fill("keepout")
        await page.keyboard.press("Enter")
        found = page.locator("#search-results").get_by_role("link", name="Local planners", exact=True)
        await found.click()
        await expect(page.get_by_role("heading", level=1)).to_contain_text("Local planners")


async def test_diagrams_are_drawn(address: str, browser: Browser) -> None:
    if not MERMAID.exists():
        pytest.skip("no script that draws diagrams; run make docs")
    context = await browser.new_context(viewport=DESK)
    async with looking(context) as page:
        for name, count in (("architecture", 2), ("data-flow", 1)):
            await page.goto(f"{address}{name}.html")
            await expect(page.locator("pre.mermaid svg")).to_have_count(count)
            await expect(page.locator("pre.mermaid", has_text="Syntax error")).to_have_count(0)


@pytest.mark.parametrize("name", ["index", "zones", "protocol", "reference/rest", "reference/commands", "adr/README"])
async def test_pages_fit_a_phone(address: str, browser: Browser, name: str) -> None:
    context = await browser.new_context(viewport=PHONE)
    async with looking(context) as page:
        await page.goto(f"{address}{name}.html")
        await expect(page.get_by_role("heading", level=1)).to_be_visible()
        wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
        assert await page.evaluate(wide) == 0

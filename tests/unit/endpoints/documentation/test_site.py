"""The documentation site as an endpoint serves it: its headers, and the answer while it is not built."""

import re
import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest

from endpoints.app import create_app
from endpoints.documentation.site import POLICY
from endpoints.http.front_settings import FrontSettings
from endpoints.resources.services import Services
from tests.support.sources import ROOT


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a site that is not built yet."""
    return tmp_path / "site"


@pytest.fixture
async def client(services: Services, folder: Path) -> AsyncIterator[httpx.AsyncClient]:
    app = create_app(services, FrontSettings(docs_site=folder))
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://cloud") as client:
        yield client


def build(folder: Path) -> None:
    (folder / "reference").mkdir(parents=True)
    (folder / "index.html").write_text("<title>PPaaS</title>")
    (folder / "reference" / "rest.html").write_text("<title>REST</title>")


@pytest.mark.parametrize("path", ["/docs-site/", "/docs-site/quickstart.html"])
async def test_while_it_is_not_built_the_answer_says_how_to_build_it(client: httpx.AsyncClient, path: str) -> None:
    answer = await client.get(path)
    assert answer.status_code == 404
    assert answer.json()["type"] == "urn:ppaas:problem:not-found"
    [target] = re.findall(r"'make (\w+)'", answer.json()["detail"])
    assert f"\n{target}: " in (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "--docs-site" in answer.json()["detail"]


async def test_a_site_that_is_built_later_is_served_until_it_is_removed(
    client: httpx.AsyncClient, folder: Path
) -> None:
    assert (await client.get("/docs-site/")).status_code == 404
    build(folder)
    assert "PPaaS" in (await client.get("/docs-site/")).text
    assert "REST" in (await client.get("/docs-site/reference/rest.html")).text
    shutil.rmtree(folder)
    assert "make docs" in (await client.get("/docs-site/")).json()["detail"]


async def test_pages_are_revalidated_and_forbid_foreign_scripts(client: httpx.AsyncClient, folder: Path) -> None:
    build(folder)
    first = await client.get("/docs-site/")
    assert first.headers["content-security-policy"] == POLICY
    assert "script-src 'self';" in POLICY
    assert (first.headers["cache-control"], first.headers["x-content-type-options"]) == ("no-cache", "nosniff")
    again = await client.get("/docs-site/", headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


async def test_the_address_without_slash_leads_to_the_site(client: httpx.AsyncClient, folder: Path) -> None:
    build(folder)
    answer = await client.get("/docs-site", follow_redirects=True)
    assert (answer.status_code, answer.url.path) == (200, "/docs-site/")


@pytest.mark.parametrize("path", ["nothing.html", "..%2fsecret", "%2e%2e/secret"])
async def test_nothing_outside_the_folder_is_served(client: httpx.AsyncClient, folder: Path, path: str) -> None:
    build(folder)
    (folder.parent / "secret").write_text("secret")
    assert (await client.get(f"/docs-site/{path}")).status_code == 404

"""Login with a real identity provider, Keycloak: in Chromium, from the command line, and of programs."""

import asyncio
import os
import re
import sys
from collections.abc import AsyncIterator, Iterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from ppaas.errors import Conflict, NotAuthenticated, NotPermitted
from robots import cli
from robots.client.rest import RestClient
from tests.servers.keycloak_server import KeycloakServer
from tests.support.cloud.browser import DESK, browsing, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, running_cloud
from tests.support.waiting import patience

pytestmark = [pytest.mark.servers, pytest.mark.asyncio(loop_scope="module")]

REFUSED = r"^Failed to load resource"


@pytest.fixture(scope="module")
def cloud(keycloak_server: KeycloakServer, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud whose people Keycloak knows."""
    folder = tmp_path_factory.mktemp("cloud")
    (folder / "secret").write_text("secret of ppaas\n")
    options = {
        "--port": keycloak_server.cloud_port,
        "--oidc-issuer": keycloak_server.issuer,
        "--oidc-client-id": "ppaas",
        "--oidc-client-secret-file": folder / "secret",
        "--oidc-cloud-url": keycloak_server.cloud_url,
        "--oidc-audience": "ppaas-api",
        "--oidc-name": "the lab",
    }
    words = [str(word) for option in options.items() for word in option]
    with running_cloud(folder, *words, "--oidc-role", "operators=admin", "--oidc-role", "staff=user") as running:
        yield running


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    async with browsing() as running:
        yield running


async def log_in(page: Page, user: str) -> None:
    """Enter user and password on the page of Keycloak."""
    await page.locator("#username").fill(user)
    await page.locator("#password").fill(f"password of {user}")
    await page.locator("#kc-login").click()


async def test_a_person_logs_in_and_out_in_the_browser(cloud: RunningCloud, browser: Browser) -> None:
    context = await browser.new_context(viewport=DESK)
    async with looking(context, REFUSED) as page:
        await page.goto(cloud.url)
        await page.get_by_role("button", name="Sign in with the lab").click()
        await log_in(page, "ann")
        await expect(page.locator("#user")).to_have_text("ann")
        assert page.url == f"{cloud.url}/dashboard/", "neither code nor token stays in the address"
        rest = RestClient(cloud.url, await page.evaluate("sessionStorage.getItem('ppaas-token')"))
        assert (await rest.get("/v1/users/me"))["role"] == "admin"
        await page.get_by_role("button", name="Log out").click()
        await expect(page.get_by_role("button", name="Sign in with the lab")).to_be_visible()
        assert page.url == f"{cloud.url}/dashboard/"
        await page.get_by_role("button", name="Sign in with the lab").click()
        await expect(page.locator("#password")).to_be_visible()  # the login at the provider has ended, too
        await log_in(page, "eve")
        await expect(page.get_by_role("alert").first).to_contain_text("none of your groups may use this cloud")
        await page.get_by_role("button", name="Sign in with the lab").click()
        await expect(page.locator("#password")).to_be_visible()  # she may have another account there
        await page.goto(f"{cloud.url}/dashboard/?state=forged&code=forged")
        await expect(page.get_by_role("alert").first).to_contain_text("not begun in this tab")
    await context.close()


async def test_a_name_that_a_local_user_has_is_refused_until_both_are_linked(
    cloud: RunningCloud, keycloak_server: KeycloakServer
) -> None:
    admin, program = await cloud.admin(), RestClient(cloud.url)
    name = "service-account-fleet"
    await admin.post("/v1/users", {"id": name, "password": ADMIN_PASSWORD})
    access = {"access_token": keycloak_server.access_token()}
    with pytest.raises(Conflict, match="ppaas user link") as refused:
        await program.post("/v1/oidc/access-tokens", access)
    subject = re.search(rf"link {name} (\S+)'", str(refused.value))
    assert subject is not None
    identity = {"issuer": keycloak_server.issuer, "subject": subject[1]}
    await admin.patch(f"/v1/users/{name}", {"identity": identity})
    login = await program.post("/v1/oidc/access-tokens", access)
    assert login["user"] == name
    with pytest.raises(NotPermitted):
        await RestClient(cloud.url, login["token"]).get("/v1/users")


async def test_the_cloud_follows_new_keys(cloud: RunningCloud, keycloak_server: KeycloakServer) -> None:
    old = {"access_token": keycloak_server.access_token()}
    keycloak_server.rotate_keys()
    new = {"access_token": keycloak_server.access_token()}
    client = RestClient(cloud.url)
    assert (await client.post("/v1/oidc/access-tokens", new))["user"] == "service-account-fleet"
    assert (await client.post("/v1/oidc/access-tokens", old))["user"] == "service-account-fleet"


async def is_taken(cloud: RunningCloud, token: str) -> bool:
    try:
        await RestClient(cloud.url, token).get("/v1/users/me")
    except NotAuthenticated:
        return False
    return True


async def test_a_command_logs_in_by_a_code_until_the_provider_reports_a_logout(
    cloud: RunningCloud, keycloak_server: KeycloakServer, browser: Browser
) -> None:
    command = [sys.executable, "-m", cli.__name__, "login", "--oidc", "--url", cloud.url]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PPAAS_")}
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE, env=environment
    )
    assert process.stderr is not None and process.stdout is not None
    told = (await process.stderr.readline()).decode()
    found = re.fullmatch(r"open (\S+) and log in; the code is ([A-Z]{4}-[A-Z]{4})\n", told)
    assert found is not None, told
    context = await browser.new_context(viewport=DESK)
    async with looking(context, REFUSED) as page:
        await page.goto(found[1])
        await log_in(page, "bob")
        await page.locator("#kc-login").click()  # grants it to the device
        token = (await process.stdout.readline()).decode().strip()
    assert await process.wait() == 0
    me = await RestClient(cloud.url, token).get("/v1/users/me")
    assert (me["id"], me["role"]) == ("bob", "user")
    await asyncio.to_thread(keycloak_server.log_out, "bob")
    async with patience(20.0):
        while await is_taken(cloud, token):
            await asyncio.sleep(0.1)
    events = await (await cloud.admin()).items("/v1/audit", action="end_provider_sessions")
    ended = [event["details"] for event in events if event["outcome"] == "ok"]  # ann's login in the browser ended, too
    assert [each["session"] for each in ended if each["tokens"] == {"bob": 1}] == [True]
    log = cloud.log.read_text()
    assert "eyJ" not in log and token not in log and "secret of ppaas" not in log
    await context.close()

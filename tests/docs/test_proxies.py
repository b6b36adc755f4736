"""The configurations of proxies.md, run with a cloud behind them.

The kind: one host with several services, which a proxy serves below a path and by TLS. Its members are pages and their
links, REST and the robots' WebSocket by all our clients, the dashboard in a browser, maps larger than a proxy takes by
default, the address of a client, and secrets in the proxy's log.
"""

import asyncio
import contextlib
import re
import shlex
import ssl
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import httpx
import numpy as np
import pytest
from playwright.async_api import WebSocket, expect

from endpoints.cli import up
from ppaas.errors import NotFound
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.cli.command_parser import CommandParser
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.browser import browsing, looking
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot, running_cloud
from tests.support.documents import blocks, script, table, text_of
from tests.support.network.proxies import RunningProxy, running_proxy
from tests.support.waiting import patience, until

pytestmark = pytest.mark.journey

PROXIES = "docs/proxies.md"
BROWSER = {"Accept": "text/html"}
OTHER_CLIENT = "127.0.0.2"
MAP = GridMap(np.zeros((1700, 1700), np.int8), GridInfo(0.05, 1700, 1700))
"""Map whose image has more than 2 MiB."""


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud that was started as the page says."""
    [command] = blocks(PROXIES, "sh")
    with running_cloud(tmp_path_factory.mktemp("cloud"), *shlex.split(command)[2:]) as running:
        yield running


@pytest.fixture(scope="module", params=["nginx", "caddy", "haproxy"])
def proxy(
    request: pytest.FixtureRequest, cloud: RunningCloud, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[RunningProxy]:
    """Return a proxy before the cloud."""
    shown, *_ = blocks(PROXIES, request.param)
    folder = tmp_path_factory.mktemp(request.param)
    with running_proxy(request.param, shown, urlsplit(cloud.url).netloc, folder) as running:
        yield running


@pytest.fixture
def rest(proxy: RunningProxy, monkeypatch: pytest.MonkeyPatch) -> RestClient:
    """Return a client that trusts the proxy's certificate."""
    monkeypatch.setenv("SSL_CERT_FILE", str(proxy.certificate.authority))
    return RestClient(proxy.url)


def browser_of(proxy: RunningProxy, address: str = "127.0.0.1") -> httpx.Client:
    context = ssl.create_default_context(cafile=str(proxy.certificate.authority))
    return httpx.Client(transport=httpx.HTTPTransport(verify=context, local_address=address), timeout=30)


def test_pages_and_their_links_work_below_the_path(proxy: RunningProxy) -> None:
    with browser_of(proxy) as client:
        front = client.get(f"{proxy.url}/", headers=BROWSER, follow_redirects=True)
        assert (front.status_code, front.url.path) == (200, "/ppaas/dashboard/")
        docs = client.get(f"{proxy.url}/docs")
        links = re.findall(r"(?:href|src)=\"([^\"]+)\"", docs.text) + re.findall(r"url: '([^']+)'", docs.text)
        assert len(links) >= 4
        for page in (front, docs):
            for link in re.findall(r"(?:href|src)=\"([^\"#]+)\"", page.text):
                assert client.get(urljoin(str(page.url), link)).status_code == 200, link
        assert client.head(f"{proxy.url}/v1/health").status_code == 200
        assert client.get(proxy.url, headers=BROWSER, follow_redirects=True).url.path == "/ppaas/dashboard/"


async def test_our_clients_work_below_the_path_and_leave_no_token_in_the_log(
    proxy: RunningProxy, rest: RestClient
) -> None:
    login = await rest.login("admin", ADMIN_PASSWORD)
    name = f"of-{proxy.name}"
    await publish_map(rest, name, MAP)  # larger than nginx takes by default
    token = await register_robot(rest, name, name, (5.0, 5.0, 0.0))
    assert [robot["id"] for robot in await rest.items("/v1/robots") if robot["id"] == name] == [name]
    async with RobotClient(proxy.url, robot=name, token=token) as robot:
        await robot.publish("chatter", String("hello"))
    with pytest.raises(NotFound):
        await rest.get("/v1/robots/none")
    assert login.token not in proxy.log
    if proxy.name == "nginx":
        await until(lambda: f"GET /ppaas/?robot={name}" in proxy.log)


async def test_failed_logins_are_counted_by_the_address_of_the_client(proxy: RunningProxy, cloud: RunningCloud) -> None:
    user = f"nobody-{proxy.name}"
    with browser_of(proxy, OTHER_CLIENT) as client:
        body = {"user": user, "password": "wrong password"}
        claimed = {"X-Forwarded-For": "192.0.2.99"}
        assert client.post(f"{proxy.url}/v1/tokens", json=body, headers=claimed).status_code == 401
    await until(lambda: f"login of '{user}' from {OTHER_CLIENT} failed" in cloud.log.read_text())


async def test_the_dashboard_and_the_viewer_work_in_a_browser(proxy: RunningProxy, rest: RestClient) -> None:
    await rest.login("admin", ADMIN_PASSWORD)
    name = f"seen-{proxy.name}"
    await publish_map(rest, name, GridMap(np.zeros((60, 60), np.int8), GridInfo(0.05, 60, 60)))
    token = await register_robot(rest, name, name, (1.0, 1.0, 0.0))
    sockets: list[WebSocket] = []
    browser_started = browsing(proxy.certificate.key_hash)
    async with RobotClient(proxy.url, robot=name, token=token), browser_started as browser:
        context = await browser.new_context()
        async with looking(context) as page:
            page.on("websocket", lambda socket: sockets.append(socket))  # noqa: PLW0108 - Playwright notes something on it
            await page.goto(f"{proxy.url}/")
            await page.get_by_label("User").fill("admin")
            await page.get_by_label("Password").fill(ADMIN_PASSWORD)
            await page.keyboard.press("Enter")
            await expect(page.locator("#user")).to_have_text("admin")
            await page.locator("#map-choice").select_option(name)
            await expect(page.get_by_role("button", name=name)).to_contain_text("no signal")
            await until(lambda: any(f"robot={name}" in socket.url for socket in sockets))
            assert all("ticket=" in socket.url and "token=" not in socket.url for socket in sockets)
        async with looking(context) as page:
            await page.goto(f"{proxy.url}/docs")
            operation = page.locator("#operations-health-show_health")
            await operation.click()
            await operation.get_by_role("button", name="Try it out").click()
            await operation.get_by_role("button", name="Execute").click()
            await expect(operation.locator(".live-responses-table .response-col_status").last).to_contain_text("200")
            await expect(operation.locator(".request-url")).to_contain_text(f"{proxy.url}/v1/health")


async def _not_ready(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Answer as an endpoint that has no master."""
    with contextlib.suppress(asyncio.IncompleteReadError):
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n")
    writer.close()


@contextlib.contextmanager
def changed_proxy(
    name: str, shown: str, cloud: RunningCloud, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[RunningProxy]:
    """Run a proxy with a changed configuration, whose certificate is trusted."""
    with running_proxy(name, shown, urlsplit(cloud.url).netloc, folder) as proxy:
        monkeypatch.setenv("SSL_CERT_FILE", str(proxy.certificate.authority))
        yield proxy


async def a_robot(proxy: RunningProxy, name: str) -> str:
    """Register a robot; return a token for it."""
    rest = RestClient(proxy.url)
    await rest.login("admin", ADMIN_PASSWORD)
    await publish_map(rest, name, MAP)
    return await register_robot(rest, name, name, (5.0, 5.0, 0.0))


async def test_a_proxy_before_two_addresses_sends_clients_to_the_one_that_is_ready(
    cloud: RunningCloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, before_two = blocks(PROXIES, "haproxy")
    other = await asyncio.start_server(_not_ready, "127.0.0.1", 0)
    address = "{}:{}".format(*other.sockets[0].getsockname())
    shown = whole.partition("\nbackend ppaas")[0] + "\n" + before_two
    shown = shown.replace("192.0.2.1:8500", address).replace("192.0.2.2:8500", urlsplit(cloud.url).netloc)
    with changed_proxy("haproxy", shown, cloud, tmp_path, monkeypatch) as proxy:
        await until(lambda: "ppaas/first is DOWN" in (tmp_path / "output.log").read_text())
        for _ in range(4):
            assert (await RestClient(proxy.url).get("/v1/health/ready"))["ready"]
        token = await a_robot(proxy, "of-two")
        async with RobotClient(proxy.url, robot="of-two", token=token) as robot:
            await robot.publish("chatter", String("hello"))
    other.close()


async def test_a_proxy_that_buffers_is_not_noticed(
    cloud: RunningCloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    [shown] = blocks(PROXIES, "nginx")
    buffering = shown.replace("proxy_request_buffering off;", "proxy_request_buffering on; proxy_buffering on;")
    assert buffering != shown
    with changed_proxy("nginx", buffering, cloud, tmp_path, monkeypatch) as proxy:
        token = await a_robot(proxy, "buffered")
        async with (
            RobotClient(proxy.url, robot="buffered", token=token) as robot,
            RobotClient(proxy.url, robot="buffered", token=token, role="operator") as operator,
        ):
            heard: list[Twist] = []
            await operator.subscribe("cmd_vel", Twist, heard.append)
            async with patience(30.0):
                while not heard:  # the subscription may come later than the first message
                    await robot.publish("cmd_vel", Twist(Vector3(0.25)))
                    await asyncio.sleep(0.1)
            assert heard[0].linear.x == 0.25


async def test_a_robot_whose_upgrade_is_lost_at_a_proxy_is_told_so(
    cloud: RunningCloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    [shown] = blocks(PROXIES, "nginx")
    without = re.sub(r"proxy_set_header (Upgrade|Connection) .*;", "", shown)
    with changed_proxy("nginx", without, cloud, tmp_path, monkeypatch) as proxy:
        with pytest.raises(NotFound, match="which a proxy must forward"):
            token = await a_robot(proxy, "plain")
            async with RobotClient(proxy.url, robot="plain", token=token):
                pass
        assert (await RestClient(proxy.url).get("/v1/health/ready"))["ready"]


def test_the_options_are_those_of_the_command() -> None:
    parser = CommandParser()
    up.configure(parser)
    known = set(re.findall(r"--[a-z-]+", parser.format_help()))
    assert set(re.findall(r"`(--[a-z-]+)", text_of(PROXIES))) <= known
    assert len(table(PROXIES, "option", "meaning")) == 4
    assert script(PROXIES) == ""

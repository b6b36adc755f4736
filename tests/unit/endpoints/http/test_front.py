"""Front of the application, over a real socket.

The kind: deployments behind a proxy, at a path, and with pages of other hosts. Its members are links and redirects
below a prefix, WebSockets at wrong paths, pages of other hosts (CORS, and ``Origin`` of WebSockets), caches in between,
and bodies that something compressed on the way.
"""

import asyncio
import gzip
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import urljoin

import httpx
import pytest
from starlette.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from endpoints.app import create_app
from endpoints.http.front import PREFIX, HeadRequests, PathPrefix, TrustedProxies, prefix_of
from endpoints.http.front_settings import FrontSettings
from endpoints.http.http_protocol import DirectHttp
from endpoints.resources.services import Services
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.robot_world import World
from tests.support.endpoints.serving import serve
from tests.support.waiting import PATIENCE
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish

BROWSER = {"Accept": "text/html"}
PAGE = "https://pages.example"


@asynccontextmanager
async def cloud_behind(services: Services, **settings: object) -> AsyncIterator[httpx.AsyncClient]:
    front = FrontSettings(**settings)  # type: ignore[arg-type]
    async with serve(create_app(services, front)) as port, httpx.AsyncClient(timeout=PATIENCE) as client:
        client.base_url = f"http://127.0.0.1:{port}"  # type: ignore[assignment]
        yield client


async def refused(url: str, **options: object) -> tuple[int, dict[str, object]]:
    with pytest.raises(InvalidStatus) as error:
        await connect(url, open_timeout=10, **options)  # type: ignore[arg-type]
    return error.value.response.status_code, json.loads(error.value.response.body or b"")


# -- paths -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("prefix", ["", "/ppaas"])
async def test_pages_and_rest_work_below_a_path_that_the_proxy_keeps_or_removes(
    services: Services, log_in: LogIn, prefix: str
) -> None:
    header = await log_in("ann")
    async with cloud_behind(services, root_path="/ppaas") as client:
        for path, target in (("/", "/ppaas/dashboard/"), ("/dashboard", "/ppaas/dashboard/")):
            answer = await client.get(prefix + path, headers=BROWSER)
            assert (answer.status_code, answer.headers["location"]) == (307, target)
        for path in ("/dashboard/", "/docs", "/openapi.json", "/v1/health"):
            assert (await client.get(prefix + path)).status_code == 200
        assert (await client.get(f"{prefix}/v1/users/me", headers=header)).json()["id"] == "ann"
        body = {"user": "ann", "password": PASSWORD}
        assert (await client.post(f"{prefix}/v1/tokens", json=body)).status_code == 201
        allowed = await client.put(f"{prefix}/v1/tokens")
        assert "POST" in allowed.headers["allow"]


async def test_limits_of_bodies_apply_below_a_path(services: Services) -> None:
    async with cloud_behind(services, root_path="/ppaas") as client:
        body = {"user": "ann", "password": "x" * services.limits.max_login}
        problem_of(await client.post("/ppaas/v1/tokens", json=body), 413, "message-too-large")


async def test_without_a_setting_all_links_are_relative(client: httpx.AsyncClient) -> None:
    outside = "https://robots.example/ppaas/"
    for path, target in (("/", "dashboard/"), ("/dashboard", "dashboard/")):
        answer = await client.get(path, headers=BROWSER)
        assert answer.headers["location"] == target
        assert urljoin(urljoin(outside, path.removeprefix("/")), target) == f"{outside}dashboard/"
    page = (await client.get("/docs")).text
    assert '"/' not in page and "'/" not in page
    described = (await client.get("/openapi.json")).json()
    assert urljoin(f"{outside}openapi.json", described["servers"][0]["url"]) == outside


@pytest.mark.parametrize("path", ["/ws", "/ppaas/", "//", "/dashboard/", "/docs/viewer/x", "/v1/maps"])
async def test_a_websocket_at_a_wrong_path_is_told_the_right_one(world: World, path: str) -> None:
    status, problem = await refused(f"ws://127.0.0.1:{world.port}{path}?robot=tb1&token={world.token}")
    assert (status, problem["type"]) == (404, "urn:ppaas:problem:not-found")
    assert problem["detail"] == f"the WebSocket of robots is at /?robot=ID, not at '{path}'"


async def test_the_right_path_is_told_with_the_prefix(services: Services) -> None:
    async with cloud_behind(services, root_path="/ppaas") as client:
        _, problem = await refused(f"ws://{client.base_url.netloc.decode()}/ppaas/ws")
    assert problem["detail"] == "the WebSocket of robots is at /ppaas/?robot=ID, not at '/ws'"


async def test_a_refused_websocket_is_logged_with_the_address_of_the_client(
    services: Services, caplog: pytest.LogCaptureFixture
) -> None:
    async with cloud_behind(services, trusted_proxies=("127.0.0.1",)) as client:
        headers = {"X-Forwarded-For": "192.0.2.9"}
        await refused(f"ws://{client.base_url.netloc.decode()}/ws", additional_headers=headers)
    [line] = [record.getMessage() for record in caplog.records if "refused" in record.getMessage()]
    assert line.startswith("192.0.2.9: WebSocket: refused: not-found: the WebSocket of robots is at /")


# -- tokens of browsers ------------------------------------------------------------------------------------------------


async def test_a_page_connects_with_a_ticket_once(world: World) -> None:
    ticket = await world.services.accounts.issue_ticket("ann", await token_hash(world))
    async with world.robot():
        async with world.connected("operator", token="", ticket=ticket) as operator:
            assert operator.subprotocol is None
        status, problem = await refused(world.url("operator", token="", ticket=ticket))
        assert (status, problem["type"]) == (401, "urn:ppaas:problem:not-authenticated")


async def test_a_page_connects_with_a_subprotocol(world: World) -> None:
    offered = ["ppaas", f"ppaas.bearer.{world.token}"]
    async with world.robot():
        url = world.url("operator", token="")
        async with connect(url, subprotocols=offered) as operator:  # type: ignore[arg-type]
            assert operator.subprotocol == "ppaas"
        async with connect(url, subprotocols=offered[1:]) as operator:  # type: ignore[arg-type]
            assert operator.subprotocol == offered[1]


async def token_hash(world: World) -> str:
    [token] = world.services.store.tokens("ann")
    return token.hash


# -- pages of other hosts ----------------------------------------------------------------------------------------------


async def test_a_websocket_of_a_page_of_another_host_is_refused(world: World) -> None:
    status, problem = await refused(world.url("operator"), origin=PAGE)
    assert (status, problem["type"]) == (403, "urn:ppaas:problem:not-permitted")
    assert PAGE in str(problem["detail"]) and "--allow-origin" in str(problem["detail"])
    async with world.robot(), connect(world.url("operator"), origin="http://127.0.0.1"):  # type: ignore[arg-type]
        header = {"Authorization": f"Bearer {world.token}"}
        url = world.url("operator", token="")
        async with connect(url, origin=PAGE, additional_headers=header):  # type: ignore[arg-type]
            pass  # browsers cannot send the header
        ticket = await world.services.accounts.issue_ticket("ann", await token_hash(world))
        async with connect(world.url("operator", token="", ticket=ticket), origin=PAGE):  # type: ignore[arg-type]
            pass  # pages of other hosts cannot get one, and a proxy may have changed the Host


async def test_without_a_setting_no_page_of_another_host_may_read(client: httpx.AsyncClient) -> None:
    answer = await client.get("/v1/health", headers={"Origin": PAGE})
    assert "access-control-allow-origin" not in answer.headers


async def test_an_allowed_page_may_send_requests_and_open_websockets(services: Services, log_in: LogIn) -> None:
    header = await log_in("ann")
    async with cloud_behind(services, allowed_origins=(PAGE,)) as client:
        asked = {
            "Origin": PAGE,
            "Access-Control-Request-Method": "PATCH",
            "Access-Control-Request-Headers": "authorization, content-type, if-match",
        }
        preflight = await client.options("/v1/maps/house/plans", headers=asked)
        assert (preflight.status_code, preflight.headers["access-control-allow-origin"]) == (200, PAGE)
        answer = await client.get("/v1/users/me", headers={**header, "Origin": PAGE})
        assert answer.headers["access-control-allow-origin"] == PAGE
        assert "access-control-allow-credentials" not in answer.headers
        other = await client.get("/v1/users/me", headers={**header, "Origin": "https://other.example"})
        assert "access-control-allow-origin" not in other.headers
        status, _ = await refused(f"ws://{client.base_url.netloc.decode()}/ws", origin=PAGE)
        assert status == 404  # not for its origin


async def test_every_origin_may_be_allowed(services: Services) -> None:
    async with cloud_behind(services, allowed_origins=("*",)) as client:
        answer = await client.get("/v1/health", headers={"Origin": "null"})
        assert answer.headers["access-control-allow-origin"] == "*"


async def test_other_settings_hold_from_the_next_request_on(services: Services) -> None:
    app = create_app(services, FrontSettings(root_path="/ppaas", allowed_origins=(PAGE,)))
    async with serve(app) as port, httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}") as client:

        async def origin_allowed() -> str | None:
            answer = await client.get("/ppaas/v1/health", headers={"Origin": PAGE})
            assert answer.status_code == 200
            return answer.headers.get("access-control-allow-origin")

        async def address_seen() -> str:
            seen = await client.get("/", headers=BROWSER | {"X-Forwarded-Prefix": "/other"})
            return str(seen.headers["location"])

        assert (await origin_allowed(), await address_seen()) == (PAGE, "/ppaas/dashboard/")
        app.front.change(FrontSettings(root_path="/ppaas", trusted_proxies=("127.0.0.1",)))
        assert (await origin_allowed(), await address_seen()) == (None, "/other/dashboard/")
        app.front.change(FrontSettings(root_path="/ppaas", allowed_origins=("*",)))
        assert (await origin_allowed(), await address_seen()) == ("*", "/ppaas/dashboard/")


# -- caches and compression --------------------------------------------------------------------------------------------


async def test_no_cache_keeps_answers_of_rest(client: httpx.AsyncClient, log_in: LogIn) -> None:
    header = await log_in("ann")
    plan = {"start": [0, 0], "goal": [1, 1]}
    for answer in (
        await client.get("/v1/maps", headers=header),
        await client.get("/v1/maps"),
        await client.get("/v1/nothing"),
        await client.post("/v1/maps/house/plans", headers=header, json=plan),
        await client.post("/v1/tokens", json={"password": "x" * 100_000}),
    ):
        assert answer.headers["cache-control"] == "no-store"
    assert (await client.get("/dashboard/")).headers["cache-control"] == "no-cache"


@pytest.mark.parametrize("coding", ["gzip", "deflate", "br", "gzip, gzip"])
async def test_a_compressed_body_is_refused_by_name(client: httpx.AsyncClient, coding: str) -> None:
    body = gzip.compress(json.dumps({"user": "ann", "password": PASSWORD}).encode())
    headers = {"Content-Type": "application/json", "Content-Encoding": coding}
    answer = await client.post("/v1/tokens", content=body, headers=headers)
    problem = problem_of(answer, 415, "unsupported-media-type")
    assert coding in problem["detail"] and "without compression" in problem["detail"]
    assert answer.headers["accept-encoding"] == "identity"


async def test_an_uncompressed_body_may_say_so(client: httpx.AsyncClient, log_in: LogIn) -> None:
    await log_in("ann")
    headers = {"Content-Encoding": "identity"}
    body = {"user": "ann", "password": PASSWORD}
    assert (await client.post("/v1/tokens", json=body, headers=headers)).status_code == 201


PROXY = "10.0.0.7"


def scope_of(path: str, client: str | None = PROXY, **headers: str) -> Scope:
    lines = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    peer = None if client is None else (client, 4711)
    return {"type": "http", "path": path, "client": peer, "scheme": "http", "headers": lines}


async def passed(make: Any, scope: Scope) -> Scope:
    """Return the scope that the application receives."""
    seen: list[Scope] = []

    async def app(scope: Scope, *_: object) -> None:
        seen.append(scope)

    await make(app)(scope, None, None)
    return seen[0]


# Path prefixes and headers of proxies.
#
# The kind: a proxy that changes what the cloud sees. It may remove the prefix of a path or keep it, name it in a
# header or not, and add the address of the client behind those that the client claims. Everybody else may send such
# headers.


@pytest.mark.parametrize(
    ("path", "inner"),
    [
        ("/ppaas", "/"),
        ("/ppaas/", "/"),
        ("/ppaas/v1/maps", "/v1/maps"),
        ("/v1/maps", "/v1/maps"),
        ("/", "/"),
        ("/ppaasx/v1", "/ppaasx/v1"),
        ("/ppaas/ppaas/v1", "/ppaas/v1"),
    ],
)
async def test_a_prefix_is_removed_and_a_removed_one_is_no_fault(path: str, inner: str) -> None:
    found = await passed(lambda app: PathPrefix(app, "/ppaas"), scope_of(path))
    assert (found["path"], prefix_of(found)) == (inner, "/ppaas")


async def test_the_scope_of_the_server_is_not_changed() -> None:
    scope = scope_of("/ppaas/v1", x_forwarded_prefix="/ppaas")
    await passed(lambda app: TrustedProxies(app, "", [PROXY]), scope)
    assert scope["path"] == "/ppaas/v1" and PREFIX not in scope


async def test_a_trusted_proxy_names_client_scheme_host_and_prefix() -> None:
    scope = scope_of(
        "/ppaas/v1/maps", x_forwarded_for="192.0.2.9", x_forwarded_proto="https", x_forwarded_prefix="/ppaas/",
        x_forwarded_host="robots.example, inner", host="127.0.0.1:8500",
    )  # fmt: skip
    found = await passed(lambda app: TrustedProxies(app, "", ["10.0.0.0/8"]), scope)
    assert (found["path"], prefix_of(found), found["scheme"]) == ("/v1/maps", "/ppaas", "https")
    assert found["client"][0] == "192.0.2.9"
    assert [value for name, value in found["headers"] if name == b"host"] == [b"robots.example"]


@pytest.mark.parametrize(
    ("claimed", "client"),
    [
        ("1.1.1.1, 192.0.2.9", "192.0.2.9"),
        ("1.1.1.1, 192.0.2.9, 10.0.0.8", "192.0.2.9"),
        ("[2001:db8::9]:80", "2001:db8::9"),
        ("", PROXY),
    ],
)
async def test_the_client_is_the_last_that_is_no_trusted_proxy(claimed: str, client: str) -> None:
    found = await passed(
        lambda app: TrustedProxies(app, "", ["10.0.0.0/8"]), scope_of("/v1/maps", x_forwarded_for=claimed)
    )
    assert found["client"][0] == client


@pytest.mark.parametrize("peer", ["192.0.2.1", None])
async def test_headers_of_others_are_ignored(peer: str | None) -> None:
    scope = scope_of(
        "/v1/maps", peer, x_forwarded_for="1.1.1.1", x_forwarded_prefix="/x", x_forwarded_host="evil", host="cloud"
    )
    found = await passed(lambda app: TrustedProxies(app, "", [PROXY]), scope)
    assert (found["path"], prefix_of(found), found["client"]) == ("/v1/maps", "", scope["client"])
    assert (b"host", b"cloud") in found["headers"]


@pytest.mark.parametrize("given", ["//evil.example", "/v1", "x", "/a b", "/../x", ""])
async def test_a_prefix_that_is_none_is_ignored(given: str) -> None:
    found = await passed(
        lambda app: TrustedProxies(app, "/ppaas", [PROXY]), scope_of("/v1/maps", x_forwarded_prefix=given)
    )
    assert (found["path"], prefix_of(found)) == ("/v1/maps", "/ppaas")


HTML = {"Accept": "text/html"}


# HEAD is answered wherever GET is, with the same head and no body.
#
# Its members: operations of REST, pages, redirects, files of the dashboard, problems, and answers that are sent in
# parts, which are not read to their end.


@pytest.mark.parametrize(
    "path",
    [
        "/v1/health",
        "/v1/maps",
        "/v1/maps/house",
        "/v1/maps/house/image",
        "/v1/maps/house/cells",
        "/v1/maps/none",
        "/v1/nothing",
        "/v1/robots",
        "/docs",
        "/openapi.json",
        "/",
        "/dashboard",
        "/dashboard/",
        "/dashboard/nothing",
    ],
)
async def test_head_is_answered_like_get(client: httpx.AsyncClient, log_in: LogIn, publish: Publish, path: str) -> None:
    header = await log_in("ann")
    await publish(header)
    got = await client.get(path, headers=header | HTML)
    head = await client.head(path, headers=header | HTML)
    assert head.status_code == got.status_code
    changing = {"x-request-id"}
    if path == "/v1/health":
        changing.add("content-length")  # it has figures of this moment
    assert {name: head.headers[name] for name in head.headers.keys() - changing} == {
        name: got.headers[name] for name in got.headers.keys() - changing
    }
    assert head.content == b""


async def test_head_needs_a_token_where_get_does_and_is_no_way_around_methods(client: httpx.AsyncClient) -> None:
    assert (await client.head("/v1/robots")).status_code == 401
    answer = await client.head("/v1/users/me/nothing")
    assert answer.status_code == 404
    answer = await client.head("/v1/maps/house/cost_matrix")
    assert (answer.status_code, answer.headers["allow"]) == (405, "POST")
    problem_of(await client.delete("/v1/health"), 405, "method-not-allowed")
    assert (await client.delete("/v1/health")).headers["allow"] == "GET, HEAD"


async def test_a_long_answer_is_not_read_to_its_end() -> None:
    read = []

    async def parts() -> AsyncIterator[bytes]:
        for number in range(1000):
            read.append(number)
            yield b"x" * 1000
            await asyncio.sleep(0.001)

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        assert scope["method"] in ("GET", "POST")
        response = StreamingResponse(parts()) if scope["path"] == "/parts" else Response("whole")
        await response(scope, receive, send)

    async with (
        serve(HeadRequests(app), http=DirectHttp) as port,
        httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client,
    ):
        for _ in range(3):
            head = await client.head("/parts")
            assert (head.status_code, head.content) == (200, b"")
        assert len(read) < 1000
        assert (await client.head("/")).headers["content-length"] == "5"
        assert (await client.get("/")).text == "whole"
        assert (await client.post("/")).text == "whole"

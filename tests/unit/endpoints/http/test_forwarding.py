"""Path prefixes and headers of proxies.

The kind: a proxy that changes what the cloud sees. It may remove the prefix of a path or keep it, name it in a header
or not, and add the address of the client behind those that the client claims. Everybody else may send such headers.
"""

from typing import Any

import pytest
from starlette.types import Scope

from endpoints.http.forwarding import PREFIX, PathPrefix, TrustedProxies, prefix_of

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

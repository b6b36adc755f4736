"""Invalid requests are answered with problems and change nothing."""

import asyncio
import errno
from typing import Any, cast

import httpx
import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.tokens import TokenCache
from endpoints.app import PREFIX, create_app
from endpoints.resources.services import RequestLimits, Services
from ppaas.errors import Unavailable
from storage import staged_uploads
from storage.ports import Store
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fuzzed_rest import operations
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, pgm, plan
from tests.support.world.urdf import example
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish

JSON = {"Content-Type": "application/json"}
FILE = b'{"map": "house", "cores": 0.25}'


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services) -> dict[str, str]:
    """Return the header of a user who has a map, a robot and a plan."""
    header = await log_in("ann")
    await publish(header)
    services.store.add_plan(plan("p1"))
    assert (await client.put("/v1/robots/tb1", headers=header | JSON, content=FILE)).status_code == 201
    return header


WITH_JSON = [
    ("POST", "/v1/tokens"),
    ("POST", "/v1/users"),
    ("PATCH", "/v1/users/me"),
    ("PATCH", "/v1/maps/house"),
    ("PUT", "/v1/robots/tb1"),
    ("PATCH", "/v1/robots/tb1"),
    ("POST", "/v1/maps/house/plans"),
    ("PUT", "/v1/maps/house/people/settings"),
    ("PATCH", "/v1/maps/house/people/settings"),
    ("POST", "/v1/maps/house/people/follow"),
    ("PUT", "/v1/robots/tb1/shares/bob"),
    ("POST", "/v1/scoped-tokens"),
    ("PUT", "/v1/groups/hall"),
]


@pytest.mark.parametrize(("method", "path"), WITH_JSON)
@pytest.mark.parametrize(
    "content",
    [b"{", b"\xff\xfe", b"{} {}", b"[" * 15_000, b'{"a": 1, "a": 2}', b'{"parameters": {"x": 1, "x": 2}}', b"9" * 5000],
    ids=["truncated", "not text", "two documents", "deep", "repeated key", "nested repeated key", "many digits"],
)
async def test_malformed_json_is_refused_by_every_operation(
    client: httpx.AsyncClient, ann: dict[str, str], method: str, path: str, content: bytes
) -> None:
    problem_of(await client.request(method, path, headers=ann | JSON, content=content), 400, "malformed-message")


@pytest.mark.parametrize(("method", "path"), WITH_JSON)
@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "json", "", "application/jsonp"])
async def test_a_body_without_a_json_content_type_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], method: str, path: str, kind: str
) -> None:
    answer = await client.request(method, path, headers=ann | {"Content-Type": kind}, content=FILE)
    assert "application/json" in problem_of(answer, 415, "unsupported-media-type")["detail"]


@pytest.mark.parametrize(
    "kind", ["application/json; charset=utf-8", "APPLICATION/JSON", "application/merge-patch+json"]
)
async def test_spellings_of_the_json_content_type_are_accepted(
    client: httpx.AsyncClient, ann: dict[str, str], kind: str
) -> None:
    answer = await client.put("/v1/robots/tb1", headers=ann | {"Content-Type": kind}, content=FILE)
    assert answer.status_code == 200


async def test_a_repeated_query_parameter_is_refused(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    twice = await client.get("/v1/maps/house/evaluation?version=a&version=b", headers=ann)
    assert "query parameter 'version' is given 2 times" in problem_of(twice, 422, "invalid-parameter")["detail"]


@pytest.mark.parametrize("value", ["1e400", "NaN", "-Infinity", '"1"', "null", "true", "[1]", "1e10", "{}"])
async def test_an_invalid_coordinate_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, value: str
) -> None:
    body = f'{{"start": [0, 0], "goal": [1, {value}]}}'
    answer = await client.post("/v1/maps/house/plans", headers=ann | JSON, content=body)
    [fault] = problem_of(answer, 422, "invalid-request")["errors"]
    assert fault["where"] == ["body", "goal", "1"]
    assert cloud.asked == []


NAMES = [
    "..",
    "%2e%2e%2fetc",
    "a%2Fb",
    "%00",
    "a%20b",
    "-a",
    "x" * 65,
    "%F0%9F%A4%96",
    "%ED%A0%80",
    "%E2%80%AEtb1",
    "%ff",
]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "resource", ["maps", "robots", "users", "plans", "tokens", "machines", "endpoints", "containers"]
)
async def test_an_invalid_name_in_the_path_is_a_client_error(
    client: httpx.AsyncClient, log_in: LogIn, resource: str, name: str
) -> None:
    url = httpx.URL("http://cloud", raw_path=f"{PREFIX}/{resource}/{name}".encode())
    for method in ("GET", "DELETE"):
        answer = await client.request(method, url, headers=await log_in("admin"))
        assert answer.status_code in (404, 405, 422), answer.text
        assert answer.headers["content-type"] == "application/problem+json"


async def test_an_unknown_path_is_a_not_found_problem(client: httpx.AsyncClient) -> None:
    for path in ("/v1/robots/", "/v1", "/v2/robots", "/v1/robots/tb1/wheels"):
        problem_of(await client.get(path), 404, "not-found")


async def test_a_body_sent_too_slowly_times_out(services: Services, log_in: LogIn) -> None:
    hurried = Services(
        services.store,
        services.map_store,
        services.accounts,
        services.cloud,
        RequestLimits(max_body_seconds=0.05, max_upload_seconds=0.05),
    )
    never = asyncio.Event()

    async def drops() -> Any:
        yield b"--"
        await never.wait()

    transport = httpx.ASGITransport(create_app(hurried))
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        form = {"Content-Type": "multipart/form-data; boundary=b"}
        for path, kind in (("/v1/tokens", JSON), ("/v1/maps", form)):
            answer = await client.post(path, headers=await log_in("ann") | kind, content=drops())
            problem_of(answer, 408, "request-timeout")
            assert answer.headers["connection"] == "close"


class DeadStore:
    """Raises an error on every access."""

    def __getattr__(self, name: str) -> Any:
        def fail(*_arguments: object, **_options: object) -> None:
            raise Unavailable("the disk is full: free space")

        return fail


QUERIES = {
    "/v1/maps/house/difference": {"old": "0" * 64},
    "/v1/plans": {"map": "house", "start": "0,0", "goal": "1,1"},
}


ELSEWHERE = (("DELETE", "/v1/tokens/x"), ("POST", "/v1/webhooks"))
"""Do not ask the store first: a token is refused at once, and removed later if need be; the master checks targets."""


def with_a_store() -> list[tuple[str, str]]:
    """Return the method and path of every operation that fails without a store."""
    # The last one answers all the same, and the master knows what is retained. Without an identity provider, `oidc`
    # asks nothing; see its own tests.
    asks_no_store = (
        "machines", "endpoints", "containers", "models", "planners", "tickets", "audit", "oidc", "retention",
        "health",
    )  # fmt: skip
    known = {"map_id": "house", "version": "0" * 64, "robot_id": "tb1", "user_id": "bob", "plan_id": "p1", "token": "x"}
    known |= {
        "node": "amcl",
        "goal_id": "rest-1",
        "number": "1",
        "grantee": "bob",
        "group_id": "hall",
        "recording_id": "x",
        "robot": "tb1",
        "task_id": "t1",
        "building_id": "hq",
        "webhook_id": "w1",
        "delivery_id": "d1",
    }
    return [
        (method.upper(), path.format(**known))
        for path, method, _ in operations()
        if path.split("/")[2] not in asks_no_store and (method.upper(), path.format(**known)) not in ELSEWHERE
    ]


STOP = {"reason": "a pallet fell"}
BODIES: dict[str, object] = {
    "/v1/tokens": {"user": "ann", "password": PASSWORD},
    "/v1/users": {"id": "bob", "password": PASSWORD},
    "/v1/users/bob": {"role": "admin"},
    "/v1/maps/house": {"readers": ["bob"]},
    "/v1/robots/tb1": {"map": "house"},
    "/v1/robots/tb1/nodes/amcl": {"home": "cloud"},
    "/v1/robots/tb1/goals": {"pose": [1, 1]},
    "/v1/robots/tb1/shares/bob": {"role": "look"},
    "/v1/robots/tb1/recordings": {"seconds": 1},
    "/v1/scoped-tokens": {"robots": ["tb1"], "role": "look"},
    "/v1/groups/hall": {"members": ["ann"]},
    "/v1/maps/house/plans": {"start": [0, 0], "goal": [1, 1]},
    "/v1/plans/p1": {"map": "house", "planner": "dijkstra", "poses": [[0, 0, 0, 0, 0, 0, 1]]},
    "/v1/maps/house/roll_back": {"version": "0" * 64},
    "/v1/maps/house/merge": {"with": "house", "into": "house"},
    "/v1/robots/tb1/map": {"publish": "house"},
    "/v1/maps/house/people/settings": {"rule": "nearest"},
    "/v1/maps/house/people/follow": {"people": []},
    "/v1/maps/house/zones": {"type": "FeatureCollection", "features": []},
    "/v1/maps/house/zones/check": {"type": "FeatureCollection", "features": []},
    "/v1/maps/house/tasks": {"kind": "go_to", "places": [[1, 1]]},
    "/v1/maps/house/reviews/1/approve": {},
    "/v1/maps/house/reviews/1/refuse": {"why": "no"},
    "/v1/acknowledgements": {"object": "cloud", "alert": "store"},
    "/v1/stop": STOP,
    "/v1/release": STOP,
    "/v1/maps/house/stop": STOP,
    "/v1/maps/house/release": STOP,
    "/v1/buildings/hq": {"floors": [{"name": "L1", "map": "house"}]},
    "PATCH /v1/buildings/hq": {"readers": ["bob"]},
    "/v1/buildings/hq/check": {"floors": [{"name": "L1", "map": "house"}]},
    "/v1/buildings/hq/plans": {"start": {"floor": "L1", "x": 0, "y": 0}, "goal": {"floor": "L1", "x": 1, "y": 1}},
    "/v1/buildings/hq/costs": {"starts": [{"floor": "L1", "x": 0, "y": 0}], "goals": []},
    "/v1/webhooks": {"url": "https://example.org", "events": ["*"]},
    "/v1/webhooks/w1": {"state": "paused"},
    "/v1/maps/house/cost_matrix": {"starts": [[0, 0]], "goals": [[1, 1]]},
    "/v1/maps/house/fleet_plans": {"starts": [[0, 0]], "goals": [[1, 1]], "radius": 0.2},
}


@pytest.fixture
async def admin(client: httpx.AsyncClient, log_in: LogIn, services: Services, passwords: Passwords) -> dict[str, str]:
    """Return the header of an administrator whose token is cached; the store fails from then on."""
    cache, dead = TokenCache(), cast(Store, DeadStore())
    object.__setattr__(services, "accounts", Accounts(services.store, passwords=passwords, cache=cache))
    header = await log_in("admin")
    await client.get("/v1/users/me", headers=header)
    object.__setattr__(services, "store", dead)
    object.__setattr__(services, "map_store", dead)
    object.__setattr__(services, "accounts", Accounts(dead, passwords=passwords, cache=cache))
    return header


@pytest.mark.parametrize(("method", "path"), with_a_store())
async def test_a_failing_store_is_unavailable_and_not_an_internal_error(
    client: httpx.AsyncClient, admin: dict[str, str], method: str, path: str
) -> None:
    body = BODIES.get(f"{method} {path}", BODIES.get(path) if method in ("POST", "PUT", "PATCH") else None)
    given: dict[str, Any] = {} if body is None else {"json": body}
    if (method, path) == ("POST", "/v1/maps"):
        given = {"data": {"id": "house"}, "files": {"yaml": ("m.yaml", YAML), "image": ("house.pgm", pgm())}}
    if (method, path) == ("PUT", "/v1/robots/tb1/urdf"):
        given, admin = {"content": example("turtlebot2")}, admin | {"Content-Type": "application/xml"}
    answer = await client.request(method, path, headers=admin, params=QUERIES.get(path), **given)
    assert "free space" in problem_of(answer, 503, "unavailable")["detail"]
    assert answer.headers["retry-after"]


async def test_a_token_is_revoked_although_the_store_fails(
    client: httpx.AsyncClient, admin: dict[str, str], services: Services
) -> None:
    assert (await client.get("/v1/planners", headers=admin)).status_code == 200
    assert (await client.delete("/v1/tokens/current", headers=admin)).status_code == 204
    # From memory no more; a store that can be read answers 401.
    problem_of(await client.get("/v1/planners", headers=admin), 503, "unavailable")
    services.accounts.close()


async def test_an_upload_to_a_full_disk_is_unavailable_and_only_operators_read_where(
    publish: Publish,
    log_in: LogIn,
    services: Services,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    def on_a_full_disk(_handle: int) -> None:
        raise OSError(errno.ENOSPC, "no space left", "/srv/draft")

    monkeypatch.setattr(staged_uploads.os, "fsync", on_a_full_disk)
    large = RequestLimits(max_upload=8 << 20)
    object.__setattr__(services, "limits", large)
    transport = httpx.ASGITransport(create_app(services))
    details = []
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        for user in ("ann", "admin"):
            files = {"yaml": ("house.yaml", YAML), "image": ("house.pgm", bytes(2 << 20))}
            answer = await client.post("/v1/maps", headers=await log_in(user), data={"id": "house"}, files=files)
            details.append(problem_of(answer, 503, "unavailable")["detail"])
    assert details[0] == "the disk is full: free space"
    assert details[1].endswith(": the disk is full: free space")
    assert details[1].startswith("/")
    assert details[1].split(":")[0].rpartition("/")[0].rpartition("/")[0] in caplog.text
    assert services.map_store.maps() == []

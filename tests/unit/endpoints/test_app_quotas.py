"""Quotas over REST."""

import asyncio
from collections.abc import Callable

import httpx
import msgspec
import pytest

from endpoints.resources.services import Services
from ppaas.errors import QuotaExceeded
from storage.records import Limits
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import pgm
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish

PATH = {"start": [0.0, 0.0], "goal": [1.0, 1.0]}


@pytest.fixture
def limit(services: Services) -> Callable[..., None]:
    """Return a function that sets a user's own limits in the store."""

    def give(user: str, **limits: float) -> None:
        changed = msgspec.structs.replace(services.store.user(user), limits=Limits(**limits))  # type: ignore[arg-type]
        services.store.change_user(changed)

    return give


@pytest.mark.parametrize("content_type", ["application/json", "application/json; charset=utf-8"])
async def test_paths_over_the_rate_are_refused_with_retry_after(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None], content_type: str
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=2)
    await publish(ann)
    headers = ann | {"Content-Type": content_type}
    for _ in range(2):
        assert (await client.post("/v1/maps/house/plans", headers=headers, json=PATH)).status_code == 201
    refused = await client.post("/v1/maps/house/plans", headers=headers, json=PATH)
    told = problem_of(refused, 429, "quota-exceeded")["detail"]
    assert "'ann' may request 2 paths a minute and has used 2;" in told and "plans_per_minute" in told
    assert 25 <= int(refused.headers["retry-after"]) <= 30
    bob = await log_in("bob")
    problem_of(await client.post("/v1/maps/house/plans", headers=bob, json=PATH), 404, "not-found")


async def test_a_cost_matrix_counts_one_path_per_start(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=5)
    await publish(ann)
    matrix = {"starts": [[0.0, 0.0]] * 4, "goals": [[1.0, 1.0]]}
    assert (await client.post("/v1/maps/house/cost_matrix", headers=ann, json=matrix)).status_code == 200
    problem_of(await client.post("/v1/maps/house/cost_matrix", headers=ann, json=matrix), 429, "quota-exceeded")
    assert (await client.post("/v1/maps/house/plans", headers=ann, json=PATH)).status_code == 201


async def test_a_plan_of_a_fleet_counts_one_path_per_robot(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=5)
    await publish(ann)
    fleet = {"starts": [[0.0, 0.0]] * 4, "goals": [[1.0, 1.0]] * 4, "radius": 0.2}
    assert (await client.post("/v1/maps/house/fleet_plans", headers=ann, json=fleet)).status_code == 200
    problem_of(await client.post("/v1/maps/house/fleet_plans", headers=ann, json=fleet), 429, "quota-exceeded")
    assert (await client.post("/v1/maps/house/plans", headers=ann, json=PATH)).status_code == 201


async def test_the_limits_in_the_store_apply_to_a_change_of_size(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud, limit: Callable[..., None]
) -> None:
    ann, cloud.running = await log_in("ann"), [container("c1")]
    limit("ann", cores=0.5)
    await client.patch("/v1/containers/c1", headers=ann, json={"cores": 0.25})
    assert cloud.quotas.limits("ann") == Limits(cores=0.5)


async def test_a_quota_of_zero_has_no_retry_after(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=0)
    await publish(ann)
    refused = await client.post("/v1/maps/house/plans", headers=ann, json=PATH)
    problem_of(refused, 429, "quota-exceeded")
    assert "retry-after" not in refused.headers


async def change(
    client: httpx.AsyncClient, headers: dict[str, str], limits: object, user: str = "ann"
) -> httpx.Response:
    return await client.patch(f"/v1/users/{user}", headers=headers, json={"limits": limits})


async def test_an_administrator_sets_limits_and_the_user_sees_them(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    await publish(ann)
    cloud.quotas.add("ann", 2, 0.75)
    assert (await change(client, admin, {"containers": 3, "cores": 0.75})).status_code == 200
    assert cloud.quotas.limits("ann") == Limits(containers=3, cores=0.75)
    told = (await client.get("/v1/users/me", headers=ann)).json()
    none = dict.fromkeys(["robots", "maps", "plans_per_minute", "stored_bytes", "versions_per_map"])
    assert told["limits"] == {"containers": 3, "cores": 0.75} | none
    assert told["quota"] == {
        "containers": 3, "cores": 0.75, "robots": 1000, "maps": 1000, "plans_per_minute": 120_000,
        "stored_bytes": 1 << 34, "versions_per_map": 1000,
    }  # fmt: skip
    stored = told["used"].pop("stored_bytes")
    assert 0 < stored < 100_000
    assert told["used"] == {
        "containers": 2, "cores": 0.75, "robots": 0, "maps": 1, "plans_per_minute": 0, "versions_per_map": 1,
    }  # fmt: skip
    with pytest.raises(QuotaExceeded, match="cores"):
        cloud.quotas.check_container("ann", 0.25)


async def test_null_removes_one_limit_or_all(client: httpx.AsyncClient, log_in: LogIn, services: Services) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    await change(client, admin, {"containers": 3, "maps": 1, "robots": 0})
    assert (await change(client, admin, {"containers": None})).json()["quota"]["containers"] == 64
    assert services.store.user("ann").limits == Limits(maps=1, robots=0)
    await change(client, admin, None)
    assert services.store.user("ann").limits == Limits()


async def test_only_administrators_change_limits(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann = await log_in("ann")
    for limits in ({"maps": 5}, {}, None):
        problem_of(await change(client, ann, limits, "me"), 403, "not-permitted")


@pytest.mark.parametrize(
    "limits",
    [
        {"maps": -1},
        {"maps": 1.5},
        {"maps": True},
        {"maps": 10**12},
        {"cores": -0.5},
        {"cores": "1"},
        {"cakes": 1},
        3,
        [],
    ],
)
async def test_invalid_limits_are_refused(client: httpx.AsyncClient, log_in: LogIn, limits: object) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    problem_of(await change(client, admin, limits), 422, "invalid-request")


async def test_concurrent_changes_of_password_and_limits_are_both_kept(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    new = client.patch("/v1/users/me", headers=ann, json={"password": "battery staple", "old_password": PASSWORD})
    given, limited = await asyncio.gather(new, change(client, admin, {"maps": 2}))
    assert (given.status_code, limited.status_code) == (200, 200)
    assert services.store.user("ann").limits == Limits(maps=2)
    await services.accounts.login("ann", "battery staple")


async def test_a_robot_over_the_quota_is_refused_and_changes_are_not(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", robots=2)
    await publish(ann)
    puts = [client.put(f"/v1/robots/tb{n}", headers=ann, json={"map": "house"}) for n in range(6)]
    answers = await asyncio.gather(*puts)
    assert sorted(answer.status_code for answer in answers) == [201, 201, 429, 429, 429, 429]
    refused = next(answer for answer in answers if answer.status_code == 429)
    assert "'ann' may have 2 robots and has 2" in problem_of(refused, 429, "quota-exceeded")["detail"]
    [kept, _] = (await client.get("/v1/robots", headers=ann)).json()["items"]
    assert (await client.put(f"/v1/robots/{kept['id']}", headers=ann, json={"map": "house"})).status_code == 200


async def test_a_map_over_the_quota_is_refused_and_new_versions_are_not(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    limit("ann", maps=1)
    await publish(bob, "other", readers="*")
    assert (await publish(ann, "first")).status_code == 201
    told = problem_of(await publish(ann, "second"), 429, "quota-exceeded")["detail"]
    assert "'ann' may have 1 maps and has 1" in told
    assert (await publish(ann, "first", image=pgm(value=0))).status_code == 201
    await client.delete("/v1/maps/first", headers=ann)
    assert (await publish(ann, "second")).status_code == 201


# -- what users store --------------------------------------------------------------------------------------------------
#
# The kind is "one user fills the disk of all". Its members: files of many versions of one map, of many maps, and URDFs.
# Plans have no quota of their own: equal segments of all users are stored once, so they belong to nobody
# alone; their number is limited by the rate of plans, and the disk by its reserve.


def new_image(number: int) -> bytes:
    return pgm(100, 100, number)


async def test_versions_beyond_the_quota_of_a_map_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", versions_per_map=2)
    for number in (1, 2):
        assert (await publish(ann, image=new_image(number))).status_code == 201
    refused = problem_of(await publish(ann, image=new_image(3)), 429, "quota-exceeded")
    assert "may have 2 versions_per_map and has 2" in refused["detail"]
    assert (await publish(ann, image=new_image(1))).status_code == 201
    assert (await client.get("/v1/users/me", headers=ann)).json()["used"]["versions_per_map"] == 2


async def test_a_version_that_keeps_its_zones_is_no_new_one(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    ring = [[-0.95, -1.95], [-0.9, -1.95], [-0.9, -1.9], [-0.95, -1.95]]
    area = {"type": "Polygon", "coordinates": [ring]}
    features = [
        {"type": "Feature", "geometry": area, "properties": {"name": name, "kind": "keep_out"}} for name in ("a", "b")
    ]
    limit("ann", versions_per_map=2)
    await publish(ann)
    one, other = ({"type": "FeatureCollection", "features": [feature]} for feature in features)
    assert (await client.put("/v1/maps/house/zones", headers=ann, json=one)).status_code == 200
    assert (await publish(ann)).status_code == 201
    refused = await client.put("/v1/maps/house/zones", headers=ann, json=other)
    problem_of(refused, 429, "quota-exceeded")
    assert (await client.delete("/v1/maps/house/zones", headers=ann)).status_code == 204
    assert (await client.get("/v1/users/me", headers=ann)).json()["used"]["versions_per_map"] == 2


async def test_map_files_beyond_the_quota_of_bytes_are_refused_until_a_version_is_removed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", stored_bytes=25_000)
    versions = [(await publish(ann, image=new_image(number))).json()["version"] for number in (1, 2)]
    refused = problem_of(await publish(ann, image=new_image(3)), 429, "quota-exceeded")
    assert "may have 25000 stored_bytes and has 2" in refused["detail"]
    assert (await publish(ann, image=new_image(2), message="the same files")).status_code == 201
    problem_of(await publish(ann, image=new_image(4), id="cellar"), 429, "quota-exceeded")
    before = (await client.get("/v1/users/me", headers=ann)).json()["used"]["stored_bytes"]
    assert 20_000 < before <= 25_000
    assert (await client.delete(f"/v1/maps/house/versions/{versions[0]}", headers=ann)).status_code == 204
    assert (await client.get("/v1/users/me", headers=ann)).json()["used"]["stored_bytes"] < before - 10_000
    assert (await publish(ann, image=new_image(3))).status_code == 201


async def test_urdfs_count_for_the_quota_of_bytes(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", stored_bytes=12_000)
    await publish(ann)
    for robot in ("tb1", "tb2"):
        await client.put(f"/v1/robots/{robot}", headers=ann, json={"map": "house"})

    async def put(robot: str, size: int) -> httpx.Response:
        urdf = b"<robot name='r'><link name='base_link'/><!--" + b"x" * size + b"--></robot>"
        path, xml = f"/v1/robots/{robot}/urdf", {"Content-Type": "application/xml"}
        return await client.put(path, headers=ann | xml, content=urdf)

    assert (await put("tb1", 8000)).status_code == 201
    problem_of(await put("tb2", 8000), 429, "quota-exceeded")
    assert (await put("tb1", 7000)).status_code == 200
    assert (await client.delete("/v1/robots/tb1/urdf", headers=ann)).status_code == 204
    assert (await put("tb2", 8000)).status_code == 201
    assert (await client.delete("/v1/robots/tb2", headers=ann)).status_code == 204
    assert (await put("tb1", 8000)).status_code == 201


async def test_files_that_an_administrator_publishes_count_for_the_owner_of_the_map(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, admin = await log_in("ann"), await log_in("admin")
    await publish(ann, image=new_image(1))
    await publish(admin, image=new_image(2))
    used = [(await client.get("/v1/users/me", headers=who)).json()["used"] for who in (ann, admin)]
    assert used[0]["stored_bytes"] > 20_000
    assert used[1]["stored_bytes"] == 0

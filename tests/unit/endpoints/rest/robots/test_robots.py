"""Robots over REST, their changes, models and nodes."""

import json
from typing import Any

import httpx
import pytest

from endpoints.resources.services import Services
from engine.master.places import robot_key
from ppaas.errors import Conflict, NotFound, PPaaSError, Unavailable
from ppaas.robot_model.known_models import model_names, robot_model
from storage.records import RobotRecord
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import clone, robot
from tests.unit.endpoints.conftest import LogIn, Publish

FILE: dict[str, Any] = {
    "map": "house",
    "model": "turtlebot2",
    "initial_pose": [1.0, 2, 0.5],
    "cores": 0.25,
    "base_global_planner": "dijkstra",
    "base_local_planner": "dwa",
    "parameters": {"DWAPlannerROS": {"max_vel_x": 0.26, "holonomic": False}},
    "description": "Carries trays on the second floor",
    "properties": {"serial": "TB-0042", "battery": {"cells": 4, "capacity": 2.2}, "sensors": ["rgbd", None]},
    "labels": {"zone": "hall-2"},
}


async def test_a_robot_is_stored_as_its_file_states(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    assert (answer.status_code, answer.json()) == (201, FILE | {"id": "tb1", "user": "ann", "role": "administer"})
    assert (await client.get("/v1/robots/tb1", headers=ann)).json() == answer.json() | {"urdf": None, "stopped": None}
    unknown = dict.fromkeys(("battery", "seen_ago", "machine", "software", "pose", "stopped"))
    state = unknown | {"connected": False, "state": "offline", "task": "", "error": ""}
    listed = {"items": [answer.json() | state], "next": None}
    assert (await client.get("/v1/robots", headers=ann)).json() == listed


async def test_only_the_map_is_required_in_a_robot_file(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    defaults = {"model": "turtlebot2", "initial_pose": [0.0, 0.0, 0.0], "cores": 1.0, "parameters": {}}
    defaults |= {"description": "", "properties": {}, "labels": {}}
    assert answer.json() == FILE | defaults | {"id": "tb1", "user": "ann", "role": "administer"}


async def test_a_robot_may_require_machine_labels(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await publish(ann)
    asks = {"map": "house", "labels": {"zone": "a", "gpu": "yes"}}
    assert (await client.put("/v1/robots/tb1", headers=ann, json=asks)).json()["labels"] == asks["labels"]
    changed = await client.patch("/v1/robots/tb1", headers=ann, json={"labels": {"gpu": None}})
    assert changed.json()["labels"] == {"zone": "a"}
    for labels in ({"a b": "c"}, {"zone": ""}, {"zone": 1}, ["zone"]):
        answer = await client.put("/v1/robots/tb1", headers=ann, json={"map": "house", "labels": labels})
        problem_of(answer, 422, "invalid-request")


async def test_users_have_their_own_robots(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann, readers="bob")
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    problem_of(await client.get("/v1/robots/tb1", headers=bob), 404, "not-found")
    await client.put("/v1/robots/tb1", headers=bob, json=FILE | {"cores": 2})
    assert (await client.get("/v1/robots/tb1", headers=ann)).json()["cores"] == 0.25
    assert (await client.delete("/v1/robots/tb1", headers=bob)).status_code == 204
    assert [r["user"] for r in (await client.get("/v1/robots", headers=ann)).json()["items"]] == ["ann"]


async def test_a_robot_may_make_a_new_map(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    answer = await client.put("/v1/robots/tb1", headers=ann, json={"map": "new:office-2"})
    assert (answer.status_code, answer.json()["map"]) == (201, "new:office-2")
    await publish(ann)
    for name in ("house", "new:house"):  # that it exists matters only when the map is published
        changed = await client.patch("/v1/robots/tb1", headers=ann, json={"map": name})
        assert (changed.status_code, changed.json()["map"]) == (200, name)


@pytest.mark.parametrize("name", ["new:", "new:../office", "new:new:office", "new: office", "new:" + "a" * 65])
async def test_a_new_map_needs_a_valid_name(client: httpx.AsyncClient, log_in: LogIn, name: str) -> None:
    answer = await client.put("/v1/robots/tb1", headers=await log_in("ann"), json={"map": name})
    problem = problem_of(answer, 422, "invalid-request")
    assert "is not a valid name of a new map: after 'new:', give the id" in json.dumps(problem)


async def test_a_robot_that_makes_a_map_has_no_masks(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    file = {"map": "house", "parameters": {"keepout_filter": {"filter_mask": "house"}}}
    problem = problem_of(
        await client.put("/v1/robots/tb1", headers=ann, json=file | {"map": "new:x"}), 422, "invalid-robot"
    )
    assert "keepout_filter: a robot that makes a new map cannot have the mask 'house'" in problem["detail"]
    assert (await client.put("/v1/robots/tb1", headers=ann, json=file)).status_code == 201
    problem_of(await client.patch("/v1/robots/tb1", headers=ann, json={"map": "new:x"}), 422, "invalid-robot")


@pytest.mark.parametrize("map_id", ["nowhere", "secret"])
async def test_a_robot_needs_a_map_that_its_user_may_read(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, map_id: str
) -> None:
    await publish(await log_in("bob"), "secret")
    answer = await client.put("/v1/robots/tb1", headers=await log_in("ann"), json={"map": map_id})
    assert problem_of(answer, 404, "not-found")["detail"] == f"unknown map {map_id!r}"


async def test_masks_of_a_robot_file_must_be_readable_maps(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await publish(await log_in("bob"), "bobs")
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    before = services.store.robots("ann")
    for parameters, error in (
        ({"keepout_filter": {"filter_mask": "nowhere"}}, "keepout_filter: the mask 'nowhere' is not a published map"),
        ({"speed_filter": {"filter_mask": "bobs"}}, "speed_filter: the mask 'bobs' is not a published map"),
        ({"speed_filter": {"type": 3}}, "speed_filter"),
    ):
        put = await client.put("/v1/robots/tb1", headers=ann, json=FILE | {"parameters": parameters})
        patched = await client.patch("/v1/robots/tb1", headers=ann, json={"parameters": parameters})
        for answer in (put, patched):
            assert error in problem_of(answer, 422, "invalid-robot")["detail"]
    assert services.store.robots("ann") == before


async def test_a_robot_whose_mask_was_removed_can_still_be_changed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await publish(ann, "kept")
    masked = {"map": "house", "parameters": {"keepout_filter": {"filter_mask": "kept"}}}
    assert (await client.put("/v1/robots/tb1", headers=ann, json=masked)).status_code == 201
    assert (await client.delete("/v1/maps/kept", headers=ann)).status_code == 204
    assert (await client.patch("/v1/robots/tb1", headers=ann, json={"cores": 0.5})).status_code == 200
    unmasked = {"parameters": {"keepout_filter": {"enabled": False}}}
    assert (await client.patch("/v1/robots/tb1", headers=ann, json=unmasked)).status_code == 200


@pytest.mark.parametrize(
    "change",
    [
        {"map": None},
        {"initial_pose": [1.0]},
        {"initial_pose": [1, 2, 3, 4]},
        {"initial_pose": ["1", 2]},
        {"initial_pose": [True, 2]},
        {"initial_pose": [float("nan"), 0.0]},
        {"initial_pose": [0.0, float("inf")]},
        {"cores": 0},
        {"cores": -1},
        {"cores": float("inf")},
        {"cores": "two"},
        {"cores": 1e9},
        {"model": "x" * 65},
        {"parameters": []},
        {"parameters": {"x": float("nan")}},
        {"parameters": {"x": ["y" * 70_000]}},
        {"paramters": {}},
        {"description": "x" * 1001},
        {"description": 5},
        {"properties": []},
        {"properties": {"x": float("inf")}},
        {"properties": {"x": ["y" * 70_000]}},
    ],
)
async def test_an_invalid_robot_file_is_refused_and_the_robot_stays(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, change: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    before = services.store.robots("ann")
    content = json_with_nan(FILE | change)
    answer = await client.put("/v1/robots/tb1", headers=ann | {"Content-Type": "application/json"}, content=content)
    if len(content) > services.limits.max_body:
        problem_of(answer, 413, "message-too-large")
    else:
        fault = problem_of(answer, 422, "invalid-request")["errors"][0]
        assert fault["where"][:2] == ["body", next(iter(change))]
    assert services.store.robots("ann") == before


def json_with_nan(value: object) -> str:
    """Return JSON that may contain NaN and Infinity."""
    return json.dumps(value)


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"\x00\xff\xfe", b"null", b"[" * 50_000, b'{"map": "\\ud800"}', b'{"\\ud800": 1}', b'{"map": 1e999}'],
)
async def test_a_malformed_robot_file_is_a_problem(client: httpx.AsyncClient, log_in: LogIn, content: bytes) -> None:
    headers = await log_in("ann") | {"Content-Type": "application/json"}
    answer = await client.put("/v1/robots/tb1", headers=headers, content=content)
    assert answer.status_code in (400, 413, 422)
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("name", ["parameters", "properties"])
@pytest.mark.parametrize("value", [{"x": 1 << 70}, {"x": "\ud800"}])
async def test_parameters_that_cannot_be_stored_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, name: str, value: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    headers = ann | {"Content-Type": "application/json"}
    content = json_with_nan(FILE | {name: value})
    answer = await client.put("/v1/robots/tb1", headers=headers, content=content)
    assert "cannot store" in problem_of(answer, 400, "invalid-input")["detail"]


async def test_an_invalid_robot_id_is_refused(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await publish(ann)
    refused = await client.put("/v1/robots/a%20b", headers=ann, json=FILE)
    assert problem_of(refused, 422, "invalid-request")["errors"][0]["where"] == ["path", "robot_id"]


async def test_a_connected_robot_cannot_be_removed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    services.store.save_clone(clone("tb1"))
    cloud.running = [container("c1"), container("c2", robot="tb2"), container("c3", user="bob")]
    cloud.presence.came(robot_key("ann", "tb1"))
    problem_of(await client.delete("/v1/robots/tb1", headers=ann), 409, "conflict")
    assert len(cloud.running) == 3
    cloud.presence.left(robot_key("ann", "tb1"))
    assert (await client.delete("/v1/robots/tb1", headers=ann)).status_code == 204
    assert [one.id for one in cloud.running] == ["c2", "c3"]  # the container that waited for it has ended
    problem_of(await client.delete("/v1/robots/tb1", headers=ann), 404, "not-found")


# Robot models over REST.


async def test_every_model_is_listed_with_its_radius(client: httpx.AsyncClient, log_in: LogIn) -> None:
    answer = await client.get("/v1/models?limit=500", headers=await log_in("ann"))
    listed = answer.json()
    assert listed["next"] is None
    assert {model["name"]: model["robot_radius"] for model in listed["items"]} == {
        name: robot_model(name).robot_radius for name in model_names()
    }


async def test_listing_models_requires_a_login(client: httpx.AsyncClient) -> None:
    assert (await client.get("/v1/models")).status_code == 401


NODES = "/v1/robots/tb1/nodes"


async def put_robot(client: httpx.AsyncClient, ann: dict[str, str], publish: Publish) -> None:
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})


# Homes of a robot's nodes over REST.


async def test_each_node_is_listed_with_its_home_and_reasons(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    page = (await client.get(NODES, headers=ann, params={"limit": 1})).json()
    assert [node["node"] for node in page["items"]] == ["amcl"]
    rest = (await client.get(NODES, headers=ann, params={"cursor": page["next"]})).json()
    assert rest == {
        "items": [
            {"node": "move_base", "home": "robot", "wanted": "robot", "score": -0.5, "reasons": ["it is near"]}
        ],
        "next": None,
    }  # fmt: skip


@pytest.mark.parametrize(("asked", "wanted"), [({}, "cloud"), ({"home": None}, "cloud"), ({"home": "robot"}, "robot")])
async def test_requesting_a_home_returns_where_the_node_will_run(
    asked: dict[str, str], wanted: str, client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    answer = await client.post(f"{NODES}/move_base", headers=ann, json=asked)
    assert (answer.status_code, answer.json()["wanted"]) == (200, wanted)


async def test_an_invalid_home_is_refused(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    for body in ({"home": "moon"}, {"home": 1}, {"house": "cloud"}, []):
        problem_of(await client.post(f"{NODES}/move_base", headers=ann, json=body), 422, "invalid-request")


@pytest.mark.parametrize(
    ("error", "status", "slug"),
    [(Unavailable("no container now"), 503, "unavailable"), (NotFound("node", "move_base"), 404, "not-found")],
)
async def test_an_unreachable_robot_or_unknown_node_is_reported(
    error: PPaaSError, status: int, slug: str,
    client: httpx.AsyncClient, cloud: FakeCloud, log_in: LogIn, publish: Publish,
) -> None:  # fmt: skip
    ann = await log_in("ann")
    await put_robot(client, ann, publish)
    cloud.error = error
    problem_of(await client.get(NODES, headers=ann), status, slug)
    problem_of(await client.post(f"{NODES}/move_base", headers=ann, json={}), status, slug)


async def test_nodes_of_other_users_robots_are_not_found(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await put_robot(client, ann, publish)
    problem_of(await client.get(NODES, headers=bob), 404, "not-found")
    problem_of(await client.post(f"{NODES}/move_base", headers=bob, json={}), 404, "not-found")


MERGE = {"Content-Type": "application/merge-patch+json"}


TUNED = {"map": "house", "cores": 0.25, "parameters": {"amcl": {"max_particles": 800, "min_particles": 100}}}


# Changes of robots, by JSON merge patch.


async def test_a_patch_changes_only_the_given_fields_of_a_robot(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=TUNED)).json()
    assert (await client.put("/v1/robots/tb1", headers=ann, json=TUNED)).status_code == 200
    patch = '{"cores": 2, "initial_pose": [1, 2], "parameters": {"amcl": {"min_particles": null}, "move_base": {}}}'
    changed = await client.patch("/v1/robots/tb1", headers=ann | MERGE, content=patch)
    parameters = {"amcl": {"max_particles": 800}, "move_base": {}}
    assert changed.json() == made | {"cores": 2.0, "initial_pose": [1.0, 2.0, 0.0], "parameters": parameters}
    reset = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": None, "parameters": None})
    assert (reset.json()["cores"], reset.json()["parameters"]) == (1.0, {})


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"map": None}, "map"),
        ({"cores": 0}, "cores"),
        ({"colour": "red"}, "colour"),
        ({"initial_pose": [1]}, "initial_pose"),
        ({"parameters": 1}, "parameters"),
        ({"model": "../x"}, "model"),
    ],
)
async def test_an_invalid_patch_is_refused_and_the_robot_stays(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any], where: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=TUNED)).json()
    answer = await client.patch("/v1/robots/tb1", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", where]
    assert (await client.get("/v1/robots/tb1", headers=ann)).json() == made | {"urdf": None, "stopped": None}


async def test_traffic_is_read_into_the_parameters(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann, amcl = await log_in("ann"), {"amcl": {"max_particles": 800, "min_particles": 100}}
    await publish(ann)

    async def put(traffic: object) -> object:
        answer = await client.put("/v1/robots/tb1", headers=ann, json=TUNED | {"traffic": traffic})
        return answer.json()["parameters"]

    async def patch(change: dict[str, Any]) -> object:
        return (await client.patch("/v1/robots/tb1", headers=ann, json=change)).json()["parameters"]

    assert await put(True) == amcl | {"traffic": {}}
    assert await put({"spacing": 0.6}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await put(False) == await put(None) == amcl
    assert await patch({"traffic": {"spacing": 0.6}}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await patch({"cores": 0.5}) == amcl | {"traffic": {"spacing": 0.6}}
    assert await patch({"traffic": True}) == amcl | {"traffic": {"spacing": 0.6}}, "its parameters stay"
    assert await patch({"traffic": None}) == amcl
    assert await patch({"parameters": None, "traffic": True}) == {"traffic": {}}
    assert await patch({"traffic": False}) == {}
    for wrong in (1, "yes", []):
        answer = await client.put("/v1/robots/tb1", headers=ann, json=TUNED | {"traffic": wrong})
        assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", "traffic"]


async def test_a_robot_is_not_moved_to_a_map_without_read_access(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann)
    await publish(bob, "secret")
    await client.put("/v1/robots/tb1", headers=ann, json=TUNED)
    problem_of(await client.patch("/v1/robots/tb1", headers=ann, json={"map": "secret"}), 404, "not-found")
    problem_of(await client.patch("/v1/robots/tb9", headers=ann, json={"cores": 1}), 404, "not-found")


async def test_a_concurrent_change_of_a_robot_is_a_conflict(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json=TUNED)
    put = services.store.put_robot

    def late(record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        put(robot("tb1", cores=3.0))
        return put(record, instead_of=instead_of)

    monkeypatch.setattr(services.store, "put_robot", late)
    answer = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": 2})
    problem_of(answer, 409, Conflict.slug)
    assert services.store.robot("ann", "tb1").cores == 3.0

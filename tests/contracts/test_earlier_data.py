"""Data of an earlier release is read, or refused with advice (``tests/earlier``)."""

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, cast

import msgspec
import pytest

from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import (
    LINK_STATE,
    LOG_STATE,
    ORIGIN_STATE,
    SESSION_STATE,
    ContainerSpec,
    MapVersion,
    RobotConfig,
)
from ppaas import __version__
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.base import Checkpoint
from ppaas.tasks.records import Task
from robots.client.rest import RestClient
from storage import encoding
from storage.encoding import decode
from storage.files import log_entries
from storage.memory.store import MemoryStore
from storage.ports import MapStore, Store
from storage.records import CloneCheckpoint, MapTask, PlanRecord
from storage.store_and_forward.plan_outbox import PlanOutbox
from storage.urls.opening import open_map_store, open_store
from tests.support.cloud.cloud import running_cloud
from tests.support.cloud.drive import driving
from tests.support.storage.earlier import (
    ADMIN_PASSWORD,
    ANN_PASSWORD,
    EARLIER,
    digest,
    expected,
    lost,
    still_said,
    unpack,
)
from tests.support.storage.records import clone, house, put_map, robot, user
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World

EVER = 3e9
"""Lifetime of a checkpoint after its cloud has exited [s]; the default is 30."""


@pytest.fixture(params=EARLIER, ids=lambda folder: folder.name)
def earlier(request: pytest.FixtureRequest) -> Path:
    folder: Path = request.param
    return folder


@pytest.fixture
def before(earlier: Path) -> dict[str, Any]:
    data: dict[str, Any] = expected(earlier)["data"]
    return data


@pytest.fixture
def files(earlier: Path, tmp_path: Path) -> Path:
    """Return a folder with a copy of its data folder and its outbox."""
    return unpack(earlier, tmp_path)


def checkpoint_of(earlier: Path) -> CloneCheckpoint:
    return decode((earlier / "checkpoint.msgpack").read_bytes(), CloneCheckpoint)


def test_data_of_an_earlier_release_exists() -> None:
    assert EARLIER


# -- the data folder ---------------------------------------------------------------------------------------------------


async def test_a_data_folder_opens_in_a_started_cloud(files: Path, before: dict[str, Any]) -> None:
    with running_cloud(files) as cloud:
        rest = RestClient(cloud.url, before["token"])
        assert await lost(cloud.url, rest, before) == []
        assert "floor" in (await labels(cloud.url))
        assert b"<robot" in await rest.fetch("/v1/robots/tb2/urdf")
        await rest.login("ann", ANN_PASSWORD)
        for number, version in enumerate(before["versions"]):
            found = await rest.fetch(f"/v1/maps/house/versions/{version['version']}/image")
            assert (found == await rest.fetch("/v1/maps/house/image")) == (number == 0)
        assert await found_between_ends(rest, before) in before["plans"]


async def test_a_clone_continues_to_the_goal_of_its_checkpoint(files: Path, before: dict[str, Any]) -> None:
    with running_cloud(files, "--linger", str(EVER)) as cloud:
        rest = RestClient(cloud.url, before["token"])
        yaml, image = [await rest.fetch(f"/v1/maps/house/{part}") for part in ("yaml", "image")]
        (pose,) = [Pose2D(*robot["initial_pose"]) for robot in before["robots"] if robot["id"] == "tb1"]
        async with driving(cloud.url, before["token"], "tb1", load_map(yaml, image), pose) as drive:
            result = await drive.result()  # nobody sent a goal
    assert (result.status.goal_id.id, result.status.status) == (before["goal_id"], Status.SUCCEEDED)


async def labels(url: str) -> dict[str, str]:
    admin = RestClient(url)
    await admin.login("admin", ADMIN_PASSWORD)
    (machine,) = await admin.items("/v1/machines")
    labels: dict[str, str] = machine["labels"]
    return labels


async def found_between_ends(rest: RestClient, before: dict[str, Any]) -> str:
    """Return which kept plan is found between the ends of one."""
    plan = next(plan for plan in before["plans"].values() if plan["planner"] == "dijkstra")
    places = [",".join(map(str, plan[end][:2])) for end in ("start", "goal")]
    found = await rest.get(f"/v1/plans?map=house&start={places[0]}&goal={places[1]}&planner=dijkstra")
    plan_id: str = found["items"][0]["plan_id"]
    return plan_id


# -- stores ------------------------------------------------------------------------------------------------------------


def test_plans_are_bitwise_equal(files: Path, before: dict[str, Any]) -> None:
    with closing(open_store(f"sqlite://{files}/data/ppaas.sqlite")) as store:
        plans = store.whole_plans(list(before["plans"]))
        assert {plan_id: digest(plan.poses) for plan_id, plan in plans.items()} == {
            plan_id: plan["poses"] for plan_id, plan in before["plans"].items()
        }
        assert plans["by-hand"].parameters == {"weight": 2.5}
        assert store.history("house")
        assert {head.id for head in store.plans("house")} == set(before["plans"])
        assert store.clone("ann", "tb1").robot == "tb1"


def test_maps_equal_the_published_ones(files: Path, before: dict[str, Any]) -> None:
    maps = open_map_store(f"file://{files}/data/maps")
    assert [record.id for record in maps.maps()] == ["cellar", "house"]
    assert [record.id for record in maps.maps(visible_to="bob")] == ["house"]
    for version in before["versions"]:
        with maps.open_map("house", version["version"]) as opened:  # by their hashes
            assert set(opened.buffers) == {"yaml", "image"}


def test_queued_plans_are_read(files: Path, earlier: Path) -> None:
    waiting = expected(earlier)["outbox"]
    with closing(PlanOutbox(files / "outbox.sqlite")) as outbox:
        records = list(outbox.oldest(100).values())
    assert {record.id: digest(record.poses) for record in records} == {
        plan_id: plan["poses"] for plan_id, plan in waiting.items()
    }


# -- checkpoints -------------------------------------------------------------------------------------------------------


def test_a_checkpoint_is_read_and_given_to_the_clone_of_its_robot(earlier: Path) -> None:
    store, checkpoint = MemoryStore(), checkpoint_of(earlier)
    store.save_clone(checkpoint)
    origin = json.loads(checkpoint.nodes[ORIGIN_STATE])
    spec = ContainerSpec(
        "c1", "ann", MapVersion(**origin["map"]), 0.25, msgspec.convert(origin["robot"], RobotConfig), session="c1"
    )
    given = CheckpointSelection(store, "another", EVER).with_checkpoint(spec).checkpoint
    marks = {SESSION_STATE, ORIGIN_STATE, LINK_STATE, LOG_STATE}
    assert {name: given[name] for name in given.keys() - marks} == {
        name: checkpoint.nodes[name] for name in checkpoint.nodes.keys() - marks
    }


def test_nodes_continue_from_their_states(earlier: Path, files: Path, before: dict[str, Any]) -> None:
    nodes = checkpoint_of(earlier).nodes
    with open_map_store(f"file://{files}/data/maps").open_map("house") as opened:
        grid = load_map(bytes(opened.buffers["yaml"]), bytes(opened.buffers["image"]))
    loop = ClosedLoop(World(grid, Pose2D(*json.loads(nodes["amcl"])["pose"])))
    loop.graph.restore([Checkpoint(name, state) for name, state in nodes.items()])
    states = {checkpoint.node: checkpoint.state for checkpoint in loop.graph.checkpoints()}
    assert {"amcl", "move_base", "waypoint_follower"} <= states.keys() & nodes.keys()
    for name in states.keys() & nodes.keys():
        assert still_said(json.loads(nodes[name]), json.loads(states[name])), name
    assert json.loads(states["move_base"])["goal"]["id"] == before["goal_id"]


# -- data of another release -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["data/ppaas.sqlite", "outbox.sqlite"])
def test_files_of_a_newer_release_are_refused_by_name(files: Path, name: str) -> None:
    with closing(sqlite3.connect(files / name)) as connection:
        connection.execute("PRAGMA user_version = 99")
    with pytest.raises(Unavailable, match=rf"{name}: written by a newer release \(schema 99\): upgrade this one"):
        PlanOutbox(files / name) if "outbox" in name else open_store(f"sqlite://{files / name}")


def test_a_log_of_maps_in_an_unknown_format_is_refused_by_name(files: Path) -> None:
    (files / "data" / "maps" / "house" / "log" / "00000003").write_bytes(b'{"format": 99}')
    with pytest.raises(Unavailable, match=r"house/log/00000003 of the maps is damaged .*: restore it from a backup"):
        open_map_store(f"file://{files}/data/maps").map_head("house")


@pytest.mark.parametrize("kind", [CloneCheckpoint, PlanRecord])
def test_a_record_in_an_unknown_format_is_refused_by_name(kind: type[msgspec.Struct]) -> None:
    with pytest.raises(Unavailable, match=f"a stored {kind.__name__} is damaged .*: restore it from a backup"):
        decode(msgspec.msgpack.encode({"format": 99}), kind)


def test_a_checkpoint_with_an_unreadable_origin_is_discarded(earlier: Path) -> None:
    store, checkpoint = MemoryStore(), checkpoint_of(earlier)
    origin = json.loads(checkpoint.nodes[ORIGIN_STATE])
    store.save_clone(msgspec.structs.replace(checkpoint, nodes=checkpoint.nodes | {ORIGIN_STATE: b'{"format": 99}'}))
    robot = msgspec.convert(origin["robot"], RobotConfig)
    spec = ContainerSpec("c1", "ann", MapVersion(**origin["map"]), 0.25, robot, session="c1")
    assert CheckpointSelection(store, "another", EVER).with_checkpoint(spec).checkpoint == {}
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")


LATER = "9.1.0"
OTHER = rf"is a record of another release of PPaaS \({LATER}\), which this one \({__version__}\) cannot read \("
TASK = Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))

# Stores in memory keep the records themselves, which no other release writes.
STORES = ["sqlite://{folder}/store.db", pytest.param("cassandra", marks=pytest.mark.servers)]
MAP_STORES = ["file://{folder}/maps", pytest.param("hdfs", marks=pytest.mark.servers)]


@pytest.fixture
def of_later_release(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let records say that a later release writes them."""
    monkeypatch.setattr(encoding, "_WRITTEN_BY", msgspec.msgpack.encode("release") + msgspec.msgpack.encode(LATER))
    monkeypatch.setattr(log_entries, "_WRITTEN_BY", b'"release":' + msgspec.json.encode(LATER) + b",")


def unknown(record: Any, **fields: object) -> Any:
    """Return a record with values that this release does not know."""
    return msgspec.structs.replace(record, **fields)


RECORDS: dict[str, tuple[Callable[[Store], None], Callable[[Store], object]]] = {
    "users/ann": (lambda s: s.add_user(unknown(user("ann"), role="janitor")), lambda s: s.user("ann")),
    "robots/bob/tb1": (
        lambda s: s.put_robot(unknown(robot("tb1", user="bob"), cores="many")),
        lambda s: s.robot("bob", "tb1"),
    ),
    "clones/bob/tb1": (
        lambda s: s.save_clone(unknown(clone("tb1", user="bob"), saved="yesterday")),
        lambda s: s.clone("bob", "tb1"),
    ),
    "tasks/bob/house/t1": (
        lambda s: s.put_task(MapTask("bob", "house", unknown(TASK, reason=5))),
        lambda s: s.task("bob", "house", "t1"),
    ),
}


# A record that another release wrote in a form that this one cannot read is named so, and spoils no other.


@pytest.mark.parametrize("store", STORES, indirect=True)
@pytest.mark.parametrize("place", RECORDS)
def test_a_record_of_another_release_is_named_with_both(store: Store, of_later_release: None, place: str) -> None:
    store.add_user(user("bob"))
    store.put_robot(robot("tb2", user="bob"))
    write, read = RECORDS[place]
    write(store)
    with pytest.raises(Unavailable, match=f"{place} {OTHER}"):
        read(store)
    assert [one.id for one in store.users() if one.id != "ann"] == ["bob"]
    assert [one.id for one in store.robots("bob") if one.id != "tb1"] == ["tb2"]


@pytest.mark.parametrize("map_store", MAP_STORES, indirect=True)
def test_a_map_of_another_release_is_named_with_both(
    map_store: MapStore, of_later_release: None, caplog: pytest.LogCaptureFixture
) -> None:
    put_map(map_store, house(map_id="shed"))
    put_map(map_store, house(description=cast(str, 5)))
    with pytest.raises(Unavailable, match=f"house/log/.* of the maps {OTHER}"):
        map_store.map_head("house")
    assert [head.id for head in map_store.maps()] == ["shed"]
    assert "of another release" in caplog.text


def test_records_of_a_later_release_that_can_be_read_are_read(store: Store, of_later_release: None) -> None:
    store.add_user(user("ann"))
    assert store.user("ann") == user("ann")

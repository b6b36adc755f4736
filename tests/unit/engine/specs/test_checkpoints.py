"""Checkpoints of the first container of a session, and of its replacements."""

import msgspec
import pytest

from engine.specs.checkpoints import CheckpointSelection, marks
from engine.specs.containers import LINK_STATE, MOVED_STATE, SESSION_STATE, ContainerSpec, MapVersion
from ppaas.clock import ManualClock
from ppaas.errors import NotFound
from ppaas.people.settings import PeopleSettings
from storage.memory.store import MemoryStore
from storage.people import MapPeople
from storage.records import CloneCheckpoint
from tests.support.engine.specs import coordinator_spec, planning_spec, robot_config, robot_spec, traffic_spec

WITHIN = 30.0
NOW = 1_000_000.0
STATE = {"amcl": b"{}", LINK_STATE: b"57"}


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(NOW)


@pytest.fixture
def checkpoints(store: MemoryStore, clock: ManualClock) -> CheckpointSelection:
    return CheckpointSelection(store, "this", WITHIN, clock)


def first(container: str = "c1") -> ContainerSpec:
    return msgspec.structs.replace(robot_spec(container), session=container)


def keep(store: MemoryStore, spec: ContainerSpec, instance: str, saved: float = NOW) -> None:
    store.save_clone(CloneCheckpoint("ann", "tb1", STATE | marks(spec, instance), saved))


def test_a_replacement_continues_from_the_checkpoint(store: MemoryStore, checkpoints: CheckpointSelection) -> None:
    keep(store, first(), "this", saved=0.0)
    replacing = msgspec.structs.replace(robot_spec("c2"), session="c1")
    assert checkpoints.with_checkpoint(replacing).checkpoint == STATE | marks(first(), "this")
    other = msgspec.structs.replace(robot_spec("c3"), session="c9")
    assert checkpoints.with_checkpoint(other).checkpoint == {}


def on(spec: ContainerSpec, map_id: str, pose: tuple[float, float, float]) -> ContainerSpec:
    """Return a spec for the same robot, brought to another map, or elsewhere."""
    assert spec.robot is not None
    robot = msgspec.structs.replace(spec.robot, initial_pose=pose, parameters={"traffic": {}})
    return msgspec.structs.replace(spec, map=MapVersion(map_id, "v7"), robot=robot)


def test_a_robot_that_has_moved_continues_without_what_belongs_to_the_map_before(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    keep(store, first(), "this", saved=0.0)
    upstairs = on(msgspec.structs.replace(robot_spec("c2"), session="c1"), "house-2", (1.0, 2.0, 0.0))
    given = checkpoints.with_checkpoint(upstairs).checkpoint
    assert MOVED_STATE in given and given["amcl"] == b"{}" and given[LINK_STATE] == b"57"
    assert checkpoints.with_checkpoint(msgspec.structs.replace(upstairs, id="c3")).checkpoint == given, (
        "also if the first container there is lost before it kept a checkpoint"
    )
    back = msgspec.structs.replace(robot_spec("c4"), session="c1")
    assert MOVED_STATE in checkpoints.with_checkpoint(back).checkpoint, "back before anything was kept there"
    keep(store, on(first("c4"), "house-2", (1.0, 2.0, 0.0)), "this")
    store.save_clone(CloneCheckpoint("ann", "tb1", STATE | marks(upstairs, "this"), NOW))
    assert MOVED_STATE not in checkpoints.with_checkpoint(msgspec.structs.replace(upstairs, id="c5")).checkpoint


def test_a_robot_that_has_moved_continues_soon_after_its_cloud_process_died(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    keep(store, first(), "that")
    given = checkpoints.with_checkpoint(on(first(), "house-2", (1.0, 2.0, 0.0))).checkpoint
    assert MOVED_STATE in given and given["amcl"] == b"{}"
    keep(store, first(), "that")
    put = on(first(), "house", (1.0, 2.0, 0.0))
    assert MOVED_STATE in checkpoints.with_checkpoint(put).checkpoint, "put elsewhere on its map"
    keep(store, first(), "that")
    other = msgspec.structs.replace(first(), robot=robot_config("tb1", model="turtlebot3_burger"))
    assert checkpoints.with_checkpoint(other).checkpoint == {}
    making = msgspec.structs.replace(first(), map=MapVersion("new:y", ""), robot=robot_config("tb1", new_map="y"))
    keep(store, msgspec.structs.replace(making, robot=robot_config("tb1", new_map="x")), "that")
    assert checkpoints.with_checkpoint(making).checkpoint == {}


def test_a_coordinator_always_continues_and_gets_the_stored_settings(
    store: MemoryStore, checkpoints: CheckpointSelection, clock: ManualClock
) -> None:
    spec = msgspec.structs.replace(coordinator_spec("k1"), session="k1")
    settings = PeopleSettings(rule="longest_seen", history=True)
    store.put_people_settings(MapPeople("ann", "house", settings))
    assert checkpoints.with_checkpoint(spec) == msgspec.structs.replace(spec, people=settings)
    state = {"people_coordinator": b"7", LINK_STATE: b"3"}
    store.save_clone(CloneCheckpoint("ann", spec.checkpoint_name, state | marks(spec, "this"), NOW))
    clock.advance(30 * 24 * 3600.0)
    later = msgspec.structs.replace(spec, id="k5", session="k5", map=MapVersion("house", "v2"))
    given = checkpoints.with_checkpoint(later)
    assert (given.checkpoint["people_coordinator"], given.checkpoint[LINK_STATE]) == (b"7", b"0")
    elsewhere = coordinator_spec("k6", version=MapVersion("depot", "v1"))
    assert checkpoints.with_checkpoint(msgspec.structs.replace(elsewhere, session="k6")).checkpoint == {}


def test_a_traffic_node_always_continues(
    store: MemoryStore, checkpoints: CheckpointSelection, clock: ManualClock
) -> None:
    spec = msgspec.structs.replace(traffic_spec("t1"), session="t1")
    assert checkpoints.with_checkpoint(spec) == spec
    store.save_clone(CloneCheckpoint("ann", spec.checkpoint_name, {"traffic": b"7"} | marks(spec, "this"), NOW))
    clock.advance(30 * 24 * 3600.0)
    later = msgspec.structs.replace(spec, id="t5", session="t5", map=MapVersion("house", "v2"))
    assert checkpoints.with_checkpoint(later).checkpoint["traffic"] == b"7"
    elsewhere = traffic_spec("t6", version=MapVersion("depot", "v1"))
    assert checkpoints.with_checkpoint(msgspec.structs.replace(elsewhere, session="t6")).checkpoint == {}


def test_only_the_last_coordinator_of_a_group_is_adopted(store: MemoryStore, checkpoints: CheckpointSelection) -> None:
    spec = msgspec.structs.replace(coordinator_spec("k1"), session="k1")
    assert not checkpoints.runs_on(spec)
    store.save_clone(CloneCheckpoint("ann", spec.checkpoint_name, marks(spec, "that"), NOW))
    assert checkpoints.runs_on(spec) and not checkpoints.runs_on(msgspec.structs.replace(spec, id="k0"))
    assert not checkpoints.runs_on(planning_spec())


def test_a_new_session_starts_from_the_robots_configuration(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    assert checkpoints.with_checkpoint(first()).checkpoint == {}
    keep(store, first("c5"), "this")
    assert checkpoints.with_checkpoint(first()).checkpoint == {}
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")


def test_robot_continues_soon_after_its_cloud_process_died(
    store: MemoryStore, checkpoints: CheckpointSelection, clock: ManualClock
) -> None:
    keep(store, first(), "that")
    clock.advance(WITHIN)
    given = checkpoints.with_checkpoint(first()).checkpoint
    assert given["amcl"] == b"{}"
    assert given[LINK_STATE] == b"0", "the messages of a new session are counted from the start"
    again = msgspec.structs.replace(robot_spec("c2"), session="c1")
    assert checkpoints.with_checkpoint(again).checkpoint == given, (
        "also if the first container dies before it kept a checkpoint"
    )


def test_a_checkpoint_that_is_too_old_or_of_the_future_is_removed(
    store: MemoryStore, checkpoints: CheckpointSelection, clock: ManualClock
) -> None:
    for saved in (NOW - WITHIN - 1.0, NOW + 60.0):
        keep(store, first(), "that", saved)
        assert checkpoints.with_checkpoint(first()).checkpoint == {}


@pytest.mark.parametrize(
    "before",
    [
        msgspec.structs.replace(first(), robot=robot_config(new_map="depot")),
        msgspec.structs.replace(first(), robot=robot_config(model="turtlebot3_burger")),
    ],
    ids=["map", "robot"],
)
def test_a_checkpoint_of_a_map_that_was_made_or_of_another_configuration_is_removed(
    store: MemoryStore, checkpoints: CheckpointSelection, before: ContainerSpec
) -> None:
    keep(store, before, "that")
    checkpoints.park("ann", "tb1")
    assert checkpoints.with_checkpoint(first()).checkpoint == {}


def test_a_robot_continues_on_another_version_of_its_map_and_masks(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    masked = robot_config(masks={"keepout_filter": MapVersion("zones", "v1")}, in_space=True)
    then = msgspec.structs.replace(first(), map=MapVersion("house", "v0"), robot=masked)
    now = then.on_maps(MapVersion("house", "v1"), {"keepout_filter": MapVersion("zones", "v2")}, in_space=False)
    keep(store, then, "that")
    assert checkpoints.runs_on(now)
    checkpoints.park("ann", "tb1")
    assert "amcl" in checkpoints.with_checkpoint(now).checkpoint


def test_a_robot_goes_on_mapping_although_the_map_that_it_continues_was_published_again(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    def mapping(map_id: str, version: str) -> ContainerSpec:
        robot = robot_config(new_map="office-2", continued=MapVersion(map_id, version))
        return msgspec.structs.replace(first(), map=MapVersion("new:office-2", ""), robot=robot)

    keep(store, mapping("office", "v1"), "that")
    checkpoints.park("ann", "tb1")
    assert "amcl" in checkpoints.with_checkpoint(mapping("office", "v2")).checkpoint
    checkpoints.park("ann", "tb1")
    assert checkpoints.with_checkpoint(mapping("house", "v2")).checkpoint == {}


def test_checkpoints_do_not_contain_the_text_of_the_urdf(store: MemoryStore, checkpoints: CheckpointSelection) -> None:
    """They are stored four times a second."""
    described = msgspec.structs.replace(first(), robot=robot_config(urdf_text=b"x" * 100_000))
    keep(store, described, "that")
    assert sum(map(len, store.clone("ann", "tb1").nodes.values())) < 2000
    checkpoints.park("ann", "tb1")
    assert checkpoints.with_checkpoint(described).checkpoint["amcl"] == STATE["amcl"]


def test_parked_robot_continues_once_at_any_time(
    store: MemoryStore, checkpoints: CheckpointSelection, clock: ManualClock
) -> None:
    keep(store, first("c5"), "this")
    checkpoints.park("ann", "tb1")
    clock.advance(1e6)
    assert checkpoints.with_checkpoint(first()).checkpoint[SESSION_STATE] == b"c1"
    assert checkpoints.with_checkpoint(first("c7")).checkpoint == {}


@pytest.mark.parametrize("origin", [b"\xff", b"{}", b"5", None])
def test_a_checkpoint_without_an_origin_is_removed(
    store: MemoryStore, checkpoints: CheckpointSelection, origin: bytes | None
) -> None:
    nodes = STATE | {SESSION_STATE: b"c1"} | ({} if origin is None else {"origin": origin})
    store.save_clone(CloneCheckpoint("ann", "tb1", nodes, NOW))
    assert checkpoints.with_checkpoint(first()).checkpoint == {}


def test_planning_container_has_no_checkpoint(checkpoints: CheckpointSelection) -> None:
    assert checkpoints.with_checkpoint(planning_spec()) == planning_spec()


def test_the_container_with_the_last_checkpoint_is_still_the_clone(
    store: MemoryStore, checkpoints: CheckpointSelection
) -> None:
    assert not checkpoints.runs_on(first()), "no checkpoint is stored"
    keep(store, first(), "before", saved=0.0)
    assert checkpoints.runs_on(first())
    assert not checkpoints.runs_on(planning_spec())


@pytest.mark.parametrize(
    ("kept_by", "instance"),
    [
        (msgspec.structs.replace(robot_spec("c2"), session="c1"), "before"),
        (msgspec.structs.replace(robot_spec("c1"), session="c9"), "before"),
        (msgspec.structs.replace(first(), map=MapVersion("depot", "v9")), "before"),
        (msgspec.structs.replace(first(), robot=robot_config("tb1", model="other")), "before"),
        (first(), "this"),
    ],
    ids=["its successor", "another session", "another map", "another robot", "this cloud process"],
)
def test_container_that_may_have_been_replaced_is_not_the_clone(
    store: MemoryStore, checkpoints: CheckpointSelection, kept_by: ContainerSpec, instance: str
) -> None:
    keep(store, kept_by, instance)
    assert not checkpoints.runs_on(first())

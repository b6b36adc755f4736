"""Joining of the maps of simulated robots while they make them, from the merge to exchanges and failures."""

import asyncio

import numpy as np
import pytest

from endpoints.merging import coordinator as module
from endpoints.merging.coordinator import JointMapCoordinator
from endpoints.merging.join_program import join_files
from endpoints.resources.joint_maps import Sharing
from endpoints.resources.services import Services
from engine.control.views import MappingRobot as MappingView
from ppaas.errors import MapsNotMerged
from ppaas.geometry import Pose2D
from ppaas.mapping.merging.united import frame_ids
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.mapping_cloud import MappingCloud
from tests.support.storage.records import house, put_map
from tests.support.world.joint_maps import joint_map, start_of
from tests.support.world.mapping_robot import MappingRobot
from tests.support.world.merge_drives import first_drive, second_drive

MET = 100
"""Scans of each robot when it may be joined with the other."""


def services(cloud):
    return Services(MemoryStore(), MemoryMapStore(), None, cloud)


class ByTruth:
    """Joins maps by the true poses of both drives; those with scans in common as the program does."""

    def __init__(self, tmp_path):
        self.calls, self.refusal, self.tmp_path = [], None, tmp_path

    def __call__(self, groups):
        self.calls.append([len(group) for group in groups])
        if self.refusal is not None:
            raise self.refusal
        paths = []
        for number, group in enumerate(groups):
            paths.append([])
            for of, file in enumerate(group):
                path = self.tmp_path / f"{number}-{of}"
                path.write_bytes(file)
                paths[-1].append(str(path))
        to = self.tmp_path / "joint"
        try:
            join_files(paths, to)
        except MapsNotMerged:
            drives = first_drive(), second_drive()
            first, second = (unpack_mapping(group[0]) for group in groups)
            joined = joint_map(*zip(drives, (first, second), strict=True))
            to.write_bytes(b"".join(pack_mapping(joined)))
        return to.read_bytes()


@pytest.fixture
def join(tmp_path):
    return ByTruth(tmp_path)


@pytest.fixture
def robots():
    both = MappingRobot(first_drive()), MappingRobot(second_drive())
    for robot in both:
        robot.step(MET)
    return both


@pytest.fixture
def cloud(robots):
    first, second = robots
    return MappingCloud(tb1=first, tb2=second)


def ids(robot):
    return set(frame_ids(robot.node._mapping()))


def off(robot):
    """Return the distance of a robot from its true pose in the frame of the first one [m]."""
    true = Pose2D(*robot.drive.true[robot.next - 1].tolist())
    return robot.in_map.distance_to(start_of(first_drive()).inverse() @ true)


async def test_two_robots_go_on_in_one_map_and_exchange_what_they_map(cloud, robots, join, monkeypatch):
    monkeypatch.setattr("endpoints.resources.joint_maps.EXCHANGE_PERIOD", 0.0)
    used = services(cloud)
    coordinator = JointMapCoordinator(used, join)
    own = [ids(robot) for robot in robots]
    first = await coordinator.step()
    assert [len(group) for group in first.groups] == [1, 1]
    assert ids(robots[0]) == ids(robots[1]) == own[0] | own[1]
    await coordinator.step()
    assert [used.joint_maps.sharing("ann", name).joined_with for name in ("tb1", "tb2")] == [("tb2",), ("tb1",)]
    for robot in robots:
        robot.step(60)
        assert off(robot) < 0.15
    assert ids(robots[0]) != ids(robots[1])
    await coordinator.step()
    assert ids(robots[0]) == ids(robots[1])
    assert len(ids(robots[0])) > len(own[0] | own[1]) + 20
    assert join.calls == [[1, 1], [2]]


async def test_reason_of_a_refusal_is_kept_and_maps_stay(cloud, robots, join):
    join.refusal = MapsNotMerged("the maps do not overlap enough: too few places")
    used = services(cloud)
    coordinator, own = JointMapCoordinator(used, join), [ids(robot) for robot in robots]
    assert await coordinator.step() is not None
    assert await coordinator.step() is None
    assert [ids(robot) for robot in robots] == own
    sharing = used.joint_maps.sharing("ann", "tb2")
    assert sharing == Sharing((), "the maps do not overlap enough: too few places", sharing.tried)


async def test_robot_that_missed_a_merge_joins_later_without_a_search(cloud, robots, join, monkeypatch):
    monkeypatch.setattr("endpoints.resources.joint_maps.EXCHANGE_PERIOD", 0.0)
    cloud.deaf.add("tb2")
    used = services(cloud)
    coordinator = JointMapCoordinator(used, join)
    await coordinator.step()
    assert ids(robots[1]) < ids(robots[0])
    cloud.deaf.clear()
    assert "no container now" in used.joint_maps.sharing("ann", "tb2").refused
    coordinator = JointMapCoordinator(services(cloud), join)  # another cloud process, which knows nothing
    robots[1].step(10)
    join.refusal = None
    await coordinator.step()
    assert ids(robots[1]) > ids(robots[0]) - ids(robots[1])
    assert len(ids(robots[1]) - ids(robots[0])) == 0
    np.testing.assert_allclose(robots[0].node._mapping().frames.poses[0], robots[1].node._mapping().frames.poses[0])


async def test_robots_of_other_joint_maps_are_not_even_asked(cloud, robots, join):
    cloud.mapping = [MappingView(each.user, each.robot, f"new:{each.robot}@ann") for each in cloud.mapping]
    assert await JointMapCoordinator(services(cloud), join).step() is None
    assert join.calls == []


async def test_robot_without_a_map_is_left_out(cloud, join):
    cloud.fleet["ann", "tb2"] = MappingRobot(second_drive())
    assert await JointMapCoordinator(services(cloud), join).step() is None


async def test_map_that_cannot_be_joined_is_left_out(cloud, join):
    robot = MappingRobot(second_drive(), mode="lifelong")
    robot.step(MET)
    cloud.fleet["ann", "tb2"] = robot
    assert await JointMapCoordinator(services(cloud), join).step() is None


async def test_maps_of_a_user_with_whom_the_published_map_is_not_shared_any_more_stay_apart(cloud, robots, join):
    cloud.fleet["bob", "tb2"] = cloud.fleet.pop(("ann", "tb2"))
    cloud.mapping = [MappingView("ann", "tb1", "new:office@ann"), MappingView("bob", "tb2", "new:office@ann")]
    used = services(cloud)
    put_map(used.map_store, house("office"))
    assert await JointMapCoordinator(used, join).step() is None
    used.map_store.change_map("office", readers=("bob",))
    join_made = await JointMapCoordinator(used, join).step()
    assert join_made.owner == "ann"
    assert ids(robots[0]) == ids(robots[1])


async def test_maps_of_others_are_joined_after_a_defect_in_a_join(cloud, join):
    cloud.fleet |= {("bob", name): robot for (_, name), robot in cloud.fleet.items()}
    cloud.mapping += [MappingView("bob", name, "new:office@bob") for name in ("tb1", "tb2")]
    join.refusal = RuntimeError("a defect")
    used = services(cloud)
    coordinator = JointMapCoordinator(used, join)
    for _ in range(2):
        with pytest.raises(RuntimeError):
            await coordinator.step()
    assert await coordinator.step() is None, "each pair is tried again when it has grown"
    assert "internal error" in used.joint_maps.sharing("ann", "tb1").refused


async def test_owner_with_other_heavy_work_delays_others_for_a_limited_time(cloud, join, monkeypatch):
    monkeypatch.setattr(module, "TURN_TIMEOUT", 0.01)
    used = services(cloud)
    async with used.heavy_work.turn("ann"), used.heavy_work.turn("ann"):
        await JointMapCoordinator(used, join).step()
    assert "other work of their owner" in used.joint_maps.sharing("ann", "tb1").refused
    assert join.calls == []


async def test_robot_that_sends_its_map_slowly_delays_others_for_a_limited_time(cloud, join, monkeypatch):
    monkeypatch.setattr(module, "TRANSFER_TIMEOUT", 0.01)
    answer = cloud.nodes.map

    async def slow(user, robot, offset):
        if offset >= 0:
            await asyncio.sleep(10.0)
        return await answer(user, robot, offset)

    cloud.nodes.map = slow
    used = services(cloud)
    await JointMapCoordinator(used, join).step()
    assert "was not transferred" in used.joint_maps.sharing("ann", "tb1").refused


async def test_joint_map_is_not_sent_if_the_published_map_is_no_longer_shared_by_then(cloud, robots, join):
    cloud.fleet["bob", "tb2"] = cloud.fleet.pop(("ann", "tb2"))
    cloud.mapping = [MappingView("ann", "tb1", "new:office@ann"), MappingView("bob", "tb2", "new:office@ann")]
    used = services(cloud)
    put_map(used.map_store, house("office"))
    used.map_store.change_map("office", readers=("bob",))

    def meanwhile(files):
        used.map_store.change_map("office", readers=())
        return join(files)

    own = [ids(robot) for robot in robots]
    await JointMapCoordinator(used, meanwhile).step()
    assert [ids(robot) for robot in robots] == own
    assert "no longer shared with 'bob'" in used.joint_maps.sharing("ann", "tb1").refused


async def test_coordinator_goes_on_after_an_error(cloud, join, monkeypatch, caplog):
    monkeypatch.setattr(module, "PERIOD", 0.0)
    coordinator, calls = JointMapCoordinator(services(cloud), join), []

    async def step():
        calls.append(1)
        if len(calls) == 2:
            raise asyncio.CancelledError
        raise RuntimeError("a defect")

    monkeypatch.setattr(coordinator, "step", step)
    with pytest.raises(asyncio.CancelledError):
        await coordinator.run()
    assert "a defect" in caplog.text

"""Places close when their map, or a mask, is no longer shared with the owner of their robot."""

import pytest

from endpoints.processes.map_rights_watch import MapRightsWatch
from tests.support.endpoints.robot_world import World, closed
from tests.support.storage import records


@pytest.fixture
def watch(world: World) -> MapRightsWatch:
    return MapRightsWatch(world.sessions, world.services)


async def test_robots_on_a_map_that_is_no_longer_shared_are_disconnected(world: World, watch: MapRightsWatch) -> None:
    async with world.robot() as (robot, _):
        await watch.check()
        store = world.services.map_store
        store.remove_map("house")
        records.put_map(store, records.house(owner="bob"))
        world.services.map_cache.forget("house")
        await watch.check()
        code, reason = await closed(robot)
        assert code == 1008
        assert reason.startswith("not-permitted: map 'house' is no longer shared with 'ann'")


async def test_robot_that_makes_a_joint_map_with_others_maps_apart_when_it_is_no_longer_shared(
    world: World, watch: MapRightsWatch
) -> None:
    store = world.services.map_store
    records.put_map(store, records.house("office", owner="bob", readers=("ann",)))
    world.services.store.put_robot(records.robot("tb1", user="ann", map="new:office"))
    async with world.robot() as (robot, container):
        await watch.check()
        await robot.ping()
        store.change_map("office", readers=())
        world.services.map_cache.forget("office")
        await watch.check()
        code, reason = await closed(robot)
        assert code != 1008, "it may connect again"
        assert reason == "unavailable: map 'office' of 'bob' is no longer shared with 'ann': connect again"
        assert await world.machine.stopped() == container.spec.id
        await world.machine.kill(container, 0)
    async with world.robot():
        [place] = world.service._master.places.values()
        assert place.request.robot is not None
        assert place.request.robot.map_owner == "ann"

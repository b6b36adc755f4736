"""Sessions end when the rights that they began with end.

Members of the kind: a token that is revoked, expires or goes with a changed password; a user who is removed or logged
out by an administrator.
"""

import pytest

from endpoints.accounts.tokens import TOKEN_LIFETIME, token_id
from endpoints.cloud_processes.cloud_jobs import MapRightsWatch
from endpoints.rosbridge import RightsWatch
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated, Unavailable
from tests.support.endpoints.robot_world import PASSWORD, World, closed
from tests.support.storage import records


@pytest.fixture
def watch(world: World) -> RightsWatch:
    return RightsWatch(world.clients, world.services)


async def test_sockets_of_a_revoked_token_are_closed_and_others_are_not(world: World, watch: RightsWatch) -> None:
    other = await world.services.accounts.login("ann", PASSWORD)
    async with world.robot() as (robot, _), world.connected("operator", token=other) as operator:
        await watch.check()
        await world.services.accounts.revoke("ann", token_id(world.token))
        await watch.check()
        code, reason = await closed(robot)
        assert code == 1008
        assert reason.startswith("not-authenticated: the token is unknown or expired")
        await watch.check()
        assert len(world.clients.attachments()) == 1
        await operator.ping()


async def test_a_socket_is_closed_when_its_token_expires(world: World, watch: RightsWatch, clock: ManualClock) -> None:
    async with world.robot() as (robot, _):
        clock.advance(TOKEN_LIFETIME)
        await watch.check()
        assert (await closed(robot))[0] == 1008


async def test_a_new_password_closes_all_sockets_but_those_of_the_token_that_set_it(
    world: World, watch: RightsWatch
) -> None:
    kept = await world.services.accounts.login("ann", PASSWORD)
    async with world.robot() as (robot, _), world.connected("operator", token=kept):
        await world.services.accounts.change("ann", password="another pass word", keep_token=token_id(kept))
        await watch.check()
        assert (await closed(robot))[0] == 1008
        await watch.check()
        assert [attachment.token for attachment in world.clients.attachments()] == [token_id(kept)]


async def test_a_removed_user_is_disconnected(world: World, watch: RightsWatch) -> None:
    async with world.robot() as (robot, _):
        await world.services.accounts.remove("ann")
        await watch.check()
        assert (await closed(robot))[0] == 1008


async def test_the_places_of_a_user_who_is_logged_out_are_closed(world: World) -> None:
    async with world.robot() as (robot, _):
        await world.service.close_places("bob", NotAuthenticated("logged out"))
        await world.service.close_places("ann", NotAuthenticated("logged out"))
        assert await closed(robot) == (1008, "not-authenticated: logged out")
        assert await world.service.containers.views(None) == []


async def test_clients_stay_while_the_store_is_unreachable(
    world: World, watch: RightsWatch, clock: ManualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_: object) -> None:
        raise Unavailable("the store is unreachable")

    async with world.robot():
        monkeypatch.setattr(world.services.store, "token", away)
        clock.advance(60.0)
        await watch.check()
        assert len(world.clients.attachments()) == 1


@pytest.fixture
def map_watch(world: World) -> MapRightsWatch:
    return MapRightsWatch(world.sessions, world.services)


# Places close when their map, or a mask, is no longer shared with the owner of their robot.


async def test_robots_on_a_map_that_is_no_longer_shared_are_disconnected(
    world: World, map_watch: MapRightsWatch
) -> None:
    async with world.robot() as (robot, _):
        await map_watch.check()
        store = world.services.map_store
        store.remove_map("house")
        records.put_map(store, records.house(owner="bob"))
        world.services.map_cache.forget("house")
        await map_watch.check()
        code, reason = await closed(robot)
        assert code == 1008
        assert reason.startswith("not-permitted: map 'house' is no longer shared with 'ann'")


async def test_robot_that_makes_a_joint_map_with_others_maps_apart_when_it_is_no_longer_shared(
    world: World, map_watch: MapRightsWatch
) -> None:
    store = world.services.map_store
    records.put_map(store, records.house("office", owner="bob", readers=("ann",)))
    world.services.store.put_robot(records.robot("tb1", user="ann", map="new:office"))
    async with world.robot() as (robot, container):
        await map_watch.check()
        await robot.ping()
        store.change_map("office", readers=())
        world.services.map_cache.forget("office")
        await map_watch.check()
        code, reason = await closed(robot)
        assert code != 1008, "it may connect again"
        assert reason == "unavailable: map 'office' of 'bob' is no longer shared with 'ann': connect again"
        assert await world.machine.stopped() == container.spec.id
        await world.machine.kill(container, 0)
    async with world.robot():
        [place] = world.service._master.places.values()
        assert place.request.robot is not None
        assert place.request.robot.map_owner == "ann"

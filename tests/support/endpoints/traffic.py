"""Traffic of the robots of the fake cloud."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing

from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficRobot, TrafficState
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.serving import serve
from tests.support.storage.records import house, put_map, robot


def add_traffic(cloud: FakeCloud, user: str, map_id: str) -> None:
    """Give a fake cloud robots tb1, which waits for tb2, and tb2, which has no goal."""
    way = [MapPoint(1.0, 2.0), MapPoint(1.5, 2.0)]
    waiting = TrafficRobot("tb1", "waiting", 1.0, 2.0, 0.5, way, "tb2", "g1", MapPoint(4.0, 2.0), 3.5)
    header = Header(stamp=Time(100, 500_000_000), frame_id="map")
    robots = [waiting, TrafficRobot("tb2", "idle", 2.0, 2.0, 0.0, [MapPoint(2.0, 2.0)])]
    cloud.traffic_states[user, map_id] = TrafficState(header, 7, 0.5, robots, 12, 0.25)


@asynccontextmanager
async def serving_traffic() -> AsyncIterator[tuple[str, str, FakeCloud]]:
    """Serve a cloud with traffic of ann's robots on the map house; return its URL, her token and the cloud."""
    store, maps, cloud = MemoryStore(), MemoryMapStore(), FakeCloud()
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    await accounts.register("ann", "correct horse", "user")
    put_map(maps, house())
    for name in ("tb1", "tb2"):
        store.put_robot(robot(name, user="ann"))
    add_traffic(cloud, "ann", "house")
    cloud.running = [container("c7", kind="traffic", robot=None)]
    with closing(accounts):
        async with serve(create_app(Services(store, maps, accounts, cloud))) as port:
            yield f"http://127.0.0.1:{port}", await accounts.login("ann", "correct horse"), cloud

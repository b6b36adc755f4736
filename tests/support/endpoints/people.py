"""People whom robots of the fake cloud see."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing

from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.views import PeopleGroupView
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleState, TrackedPerson
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.serving import serve
from tests.support.storage.records import house, put_map, robot


def person(number: int, x: float = 1.0, **fields: object) -> TrackedPerson:
    """Return a person."""
    given = {"velocity": Point(0.5, 0.0), "covariance": [0.01, 0.0, 0.0, 0.01], "seen_by": ["tb1/4"]}
    times = {"first_seen": Time(90), "last_seen": Time(100)}
    return TrackedPerson(number, Point(x, 2.0), **(given | times | fields))  # type: ignore[arg-type]


def people_state(*people: TrackedPerson) -> PeopleState:
    """Return a state in which robot tb1 follows person 1."""
    order = FollowOrder("tb1", 1, 3.5, Time(95), "nearest")
    robot = GroupRobot("tb1", Point(0.0, 2.0), 0.2, len(people))
    header = Header(stamp=Time(100, 500_000_000), frame_id="map")
    return PeopleState(header, len(people), list(people), [order], [robot], "nearest", 0.001)


def add_group(cloud: FakeCloud, user: str, map_id: str, *people: TrackedPerson) -> None:
    """Give a fake cloud a group of the robots tb1 and tb2 that see these people."""
    cloud.groups.append(PeopleGroupView(user, map_id, ("tb1", "tb2"), "ready"))
    cloud.people_states[user, map_id] = people_state(*people)


@asynccontextmanager
async def serving_people() -> AsyncIterator[tuple[str, str, MemoryStore]]:
    """Serve a cloud in which ann's robots see two people in the map house; return its URL, her token and its store."""
    store, maps, cloud = MemoryStore(), MemoryMapStore(), FakeCloud()
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    await accounts.register("ann", "correct horse", "user")
    put_map(maps, house())
    store.put_robot(robot("tb1", user="ann"))
    add_group(cloud, "ann", "house", person(1), person(2, x=0.0, state="predicted", seen_by=[]))
    with closing(accounts):
        async with serve(create_app(Services(store, maps, accounts, cloud))) as port:
            yield f"http://127.0.0.1:{port}", await accounts.login("ann", "correct horse"), store

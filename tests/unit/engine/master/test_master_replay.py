"""Sequences of events: the master's counts stay correct, and a replay of its log gives the same state and orders."""

import contextlib
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from msgspec.structs import replace

from engine.master.balancer import Balancer
from engine.master.balancers.first_fit import FirstFit
from engine.master.balancers.ppaas import SameMap
from engine.master.events import (
    ContainerLaunched,
    ContainerLost,
    ContainerReady,
    DefaultQuotaChanged,
    Event,
    LimitsChanged,
    MachineAdmitted,
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MachinesExpected,
    MapChanged,
    PlaceReleased,
    PlaceRequested,
    RemovalRequested,
    ResizeRequested,
    ReturnTimedOut,
    RobotTimed,
    SettingsChanged,
    SettingsLoaded,
    ShutdownBegan,
)
from engine.master.master import LOG_SIZE, MOVES, Master
from engine.master.orders import Order
from engine.master.places import PlaceAssignment, PlaceRequest, people_key, robot_key, traffic_key
from engine.master.queueing import FullMachines
from engine.master.quotas import Quota, Quotas
from engine.protocols.control_link import Heartbeat, RunningContainer
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import InvalidMap, PPaaSError, Unavailable
from storage.records import Limits
from tests.support.engine.placing import joined
from tests.support.engine.specs import coordinator_spec, robot_config, robot_request, traffic_spec

MACHINES = st.sampled_from(["m1", "m2", "m3"])
ROBOTS = st.sampled_from("abcdefgh")
USERS = st.sampled_from(["u", "v"])
SIZES = st.sampled_from([0.25, 1.0, 2.0, 9.0])
CONTAINERS = st.integers(1, 60).map(lambda number: f"c{number}")
TIMES = st.floats(0.0, 1.0)
LABELS = st.sampled_from([{}, {"zone": "a"}])
MAPS = st.sampled_from(["office", "house"]).map(lambda name: MapVersion(name, "v1"))
MASKS = {"keepout_filter": MapVersion("house", "v1"), "speed_filter": MapVersion("speeds", "v1")}
CONFIGS = ROBOTS.map(robot_config) | ROBOTS.map(lambda robot: robot_config(robot, masks=MASKS))
REQUESTS = st.builds(PlaceRequest, USERS, MAPS, SIZES, st.none() | CONFIGS, labels=LABELS) | st.builds(
    PlaceRequest, USERS, MAPS, SIZES, group_node=st.sampled_from(["people", "traffic"])
)
SETTINGS = st.builds(MachineSettings, LABELS, st.sampled_from([0, 2, 100]), draining=st.booleans())
LOADS = st.builds(Heartbeat, st.floats(0.0, 4.0), st.just(0), st.just([]), round_trips=st.dictionaries(MACHINES, TIMES))
GROUPS = (USERS, st.sampled_from(["office", "house"]))
KEYS = st.builds(robot_key, USERS, ROBOTS) | st.builds(people_key, *GROUPS) | st.builds(traffic_key, *GROUPS)


def carried(container: str, user: str, robot: str, map_version: MapVersion) -> RunningContainer:
    spec = ContainerSpec(container, user, map_version, 1.0, robot_config(robot), session=f"s-{container}")
    return RunningContainer(spec, 1.0, "secret", 42)


def coordinating(container: str, user: str, map_version: MapVersion, *, traffic: bool) -> RunningContainer:
    made = traffic_spec if traffic else coordinator_spec
    spec = replace(made(container, user, map_version), session=f"s-{container}")
    return RunningContainer(spec, 1.0, "secret", 43)


OLD = st.sampled_from(["old1", "old2"])
CARRIED = st.builds(carried, OLD, USERS, ROBOTS, MAPS) | st.builds(
    coordinating, OLD, USERS, MAPS, traffic=st.booleans()
)
JOINED = st.builds(joined, MACHINES, st.integers(1, 3), carries=st.just(()) | st.lists(CARRIED, max_size=2).map(tuple))
REASONS = st.sampled_from([Unavailable("boom"), InvalidMap("not square")])

RARE: list[st.SearchStrategy[Event]] = [
    st.builds(
        MapChanged,
        st.sampled_from(["office", "house"]).map(lambda name: MapVersion(name, "v2")),
        st.booleans(),
        st.integers(0, 3),
    ),
    st.builds(LimitsChanged, USERS, st.builds(Limits, st.none() | st.integers(0, 4))),
    st.builds(DefaultQuotaChanged, st.builds(Quota, st.integers(0, 4))),
    st.builds(SettingsLoaded, st.dictionaries(MACHINES, SETTINGS), st.lists(MACHINES).map(tuple)),
    st.builds(MachinesExpected, st.lists(MACHINES).map(tuple)),
    st.builds(ReturnTimedOut),
    st.builds(ShutdownBegan),
]
USUAL: list[st.SearchStrategy[Event]] = [
    st.builds(PlaceRequested, REQUESTS, st.booleans()),
    st.builds(PlaceReleased, KEYS),
    st.builds(ResizeRequested, CONTAINERS, SIZES),
    st.builds(SettingsChanged, MACHINES, SETTINGS),
    st.builds(RemovalRequested, MACHINES, st.booleans()),
    st.builds(MachineAdmitted, MACHINES),
    JOINED,
    st.builds(MachineMeasured, MACHINES, LOADS),
    st.builds(MachineLeft, MACHINES),
    st.builds(ContainerLaunched, MACHINES, CONTAINERS, st.integers(1, 9)),
    st.builds(ContainerReady, CONTAINERS, st.integers(1, 9)),
    st.builds(ContainerLost, CONTAINERS, REASONS, st.floats(0.0, 100.0)),
    st.builds(ContainerLost, CONTAINERS, REASONS, st.floats(0.0, 100.0), MACHINES),
    st.builds(RobotTimed, KEYS, TIMES),
]


def new_master(balancer: Balancer, log_size: int | None = None) -> Master:
    return Master(balancer, Quotas(Quota(6, 4.0)), log_size=log_size)


def orders_of(master: Master, event: Event) -> list[Order] | str:
    """Return the orders of an event, or the refusal of it."""
    try:
        return master.handle(event)
    except PPaaSError as error:
        return repr(error)


def state_of(master: Master) -> dict[str, Any]:
    """Return the whole state of a master, in a form that can be compared."""
    state = vars(master._state)
    plain = {name: value for name, value in state.items() if name not in ("balancer", "quotas", "queue")}
    balancer, tree = vars(state["balancer"]).copy(), vars(state["balancer"]).get("_tree")
    balancer.pop("_weights", None)
    balancer["_tree"] = vars(tree) if tree is not None else None
    return plain | {
        "waiting": list(state["waiting"]),
        "quotas": vars(state["quotas"]),
        "queue": list(state["queue"]._requests.items()),
        "balancer": balancer,
    }


class MasterMachine(RuleBasedStateMachine):
    """A master that handles any sequence of events."""

    balancer: type[Balancer] = FirstFit

    def __init__(self) -> None:
        super().__init__()
        self.master = new_master(self.balancer())
        self.orders: list[str] = []

    @rule(event=st.one_of(*USUAL))
    def usual(self, event: Event) -> None:
        self.orders.append(repr(orders_of(self.master, event)))

    @rule(event=st.one_of(*RARE))
    def rare(self, event: Event) -> None:
        self.usual(event)

    @rule(event=JOINED)
    def join(self, event: MachineJoined) -> None:
        self.usual(event)

    def teardown(self) -> None:
        again = new_master(self.balancer())
        assert [repr(orders_of(again, event)) for event in self.master.log] == self.orders
        assert state_of(again) == state_of(self.master)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(FullMachines, "refuse", lambda *_: False)
            asking = new_master(self.balancer())
            assert [repr(orders_of(asking, event)) for event in self.master.log] == self.orders, "each place was tried"

    @invariant()
    def containers_and_places_correspond(self) -> None:
        placed = {m.id: set(m.containers) for m in self.master.machines.values()}
        filled: dict[str, set[str]] = {name: set() for name in placed}
        for place in self.master.places.values():
            assert (place.spec is None) == (place.machine is None) == (place.state == "waiting")
            assert place.successor is None or place.leaving
            for machine_id, spec in filter(None, [(place.machine, place.spec), place.successor]):
                if spec is not None and machine_id is not None:
                    filled[machine_id].add(spec.id)
        assert placed == filled

    @invariant()
    def places_are_found_by_each_of_their_maps(self) -> None:
        users: dict[str, dict[str, PlaceAssignment]] = {}
        for key, place in self.master.places.items():
            for map_id in place.request.map_ids:
                users.setdefault(map_id, {})[key] = place
        found = self.master._state.users_of
        assert found == users
        assert {name: list(those) for name, those in found.items()} == {n: list(those) for n, those in users.items()}

    @invariant()
    def number_of_moving_places_is_limited(self) -> None:
        assert sum(place.leaving for place in self.master.places.values()) <= MOVES
        assert self.master._state.moving <= self.master.places.keys()

    @invariant()
    def usage_is_the_sum_of_the_places(self) -> None:
        for user in ("u", "v"):
            sizes = [place.cores for place in self.master.places.values() if place.request.user == user]
            used = self.master._state.quotas.used(user)
            assert (used.containers, used.cores) == (len(sizes), pytest.approx(sum(sizes)))

    @invariant()
    def machines_give_no_more_than_they_have(self) -> None:
        assert all(m.free >= -1e-9 for m in self.master.machines.values())


class SameMapMachine(MasterMachine):
    balancer = SameMap


MasterMachine.TestCase.settings = settings(stateful_step_count=40)
SameMapMachine.TestCase.settings = MasterMachine.TestCase.settings
TestFirstFitMaster = MasterMachine.TestCase
TestSameMapMaster = SameMapMachine.TestCase


def test_log_keeps_the_last_events_including_refused_ones() -> None:
    master = new_master(FirstFit(), log_size=3)
    refused = PlaceRequested(robot_request(cores=9.0))
    events = [joined("m1"), MachineLeft("m1"), joined("m2"), refused]
    for event in events:
        with contextlib.suppress(PPaaSError):
            master.handle(event)
    assert list(master.log) == events[1:]


def test_the_log_is_bounded_by_default() -> None:
    assert Master(FirstFit()).log.maxlen == LOG_SIZE

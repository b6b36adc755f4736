"""Tests of machine administration: draining, limits, labels and removal."""

from collections.abc import Sequence
from typing import Any

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.balancers.ppaas import SameMap
from engine.master.events import (
    ContainerLaunched,
    ContainerLost,
    ContainerReady,
    MachineAdmitted,
    MachineLeft,
    MachineMeasured,
    PlaceReleased,
    PlaceRequested,
    RemovalRequested,
    RobotTimed,
    SettingsChanged,
)
from engine.master.master import MOVES, Master
from engine.master.orders import Close, End, Leave, Order, Start
from engine.master.places import PlaceRequest
from engine.protocols.control_link import ContainerLoad, Heartbeat
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import Conflict, InvalidParameter, NotFound, NotPermitted, Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import robot_request

DRAINING = MachineSettings(draining=True)
GONE = Unavailable("it exited with status 0")
NOW = 100.0


@pytest.fixture
def master() -> Master:
    made = Master(FirstFit())
    made.handle(joined("m1", 4))
    return made


def started(orders: Sequence[Order]) -> Start:
    (start,) = [order for order in orders if isinstance(order, Start)]
    return start


def leaves(orders: Sequence[Order]) -> list[str]:
    return [order.container for order in orders if isinstance(order, Leave)]


def run(master: Master, robot: str, **fields: Any) -> str:
    """Open a place and make its container ready; return the container."""
    container = started(master.handle(PlaceRequested(robot_request(robot, **fields)))).spec.id
    master.handle(ContainerReady(container, 42))
    return container


def on(master: Master, machine_id: str) -> set[str]:
    return set(master.machines[machine_id].containers)


# -- draining ----------------------------------------------------------------------------------------------------------


def test_container_of_a_drained_machine_moves_to_another(master: Master) -> None:
    first = run(master, "r1")
    master.handle(joined("m2"))
    assert master.handle(SettingsChanged("m1", DRAINING)) == [Leave("robot:ann/r1", "m1", first)]
    assert on(master, "m1") == {first} and len(on(master, "m2")) == 1, "capacity is reserved for it"
    assert master.is_leaving(first)
    start = started(master.handle(ContainerLost(first, GONE, NOW)))
    assert (start.machine, start.delay, start.spec.session) == ("m2", 0.0, first)
    assert on(master, "m1") == set() and on(master, "m2") == {start.spec.id}
    assert master.places["robot:ann/r1"].crashes == [], "leaving is not a crash"
    master.handle(ContainerReady(start.spec.id, 43))
    assert master.places["robot:ann/r1"].state == "ready"


def test_drained_machine_gets_no_container_until_draining_ends(master: Master) -> None:
    master.handle(SettingsChanged("m1", DRAINING))
    with pytest.raises(Unavailable, match="no machine has room"):
        master.handle(PlaceRequested(robot_request("r1")))
    master.handle(SettingsChanged("m1", MachineSettings()))
    assert started(master.handle(PlaceRequested(robot_request("r1")))).machine == "m1"


def test_number_of_concurrent_moves_is_limited(master: Master) -> None:
    ran = [run(master, f"r{number}") for number in range(MOVES + 2)]
    master.handle(joined("m2", 4))
    left = leaves(master.handle(SettingsChanged("m1", DRAINING)))
    assert left == ran[:MOVES]
    for number in range(2):
        successor = started(master.handle(ContainerLost(left[number], GONE, NOW)))
        assert leaves(master.handle(ContainerReady(successor.spec.id, 43))) == [ran[MOVES + number]]


def test_container_that_fits_nowhere_stays_until_there_is_capacity(master: Master) -> None:
    first = run(master, "r1", cores=2.0)
    assert master.handle(SettingsChanged("m1", DRAINING)) == []
    assert master.handle(joined("small", 1)) == []
    assert leaves(master.handle(joined("m2", 2))) == [first]


def test_starting_container_moves_when_it_is_ready(master: Master) -> None:
    first = started(master.handle(PlaceRequested(robot_request("r1")))).spec.id
    master.handle(joined("m2"))
    assert master.handle(SettingsChanged("m1", DRAINING)) == []
    assert leaves(master.handle(ContainerReady(first, 42))) == [first]


def test_container_lost_while_leaving_is_replaced_elsewhere(master: Master) -> None:
    first = run(master, "r1")
    master.handle(joined("m2"))
    master.handle(SettingsChanged("m1", DRAINING))
    assert started(master.handle(MachineLeft("m1"))).machine == "m2"
    assert not master.is_leaving(first)


def test_move_target_may_be_lost_before_the_container_exits(master: Master) -> None:
    first = run(master, "r1")
    master.handle(joined("m2"))
    master.handle(SettingsChanged("m1", DRAINING))
    assert master.handle(MachineLeft("m2")) == []
    assert master.handle(ContainerLost(first, GONE, NOW)) == [], "the place waits"
    assert started(master.handle(joined("m3"))).machine == "m3"


def test_place_released_during_a_move_frees_the_reservation(master: Master) -> None:
    first = run(master, "r1")
    master.handle(joined("m2"))
    master.handle(SettingsChanged("m1", DRAINING))
    assert master.handle(PlaceReleased("robot:ann/r1")) == [End("m1", first)]
    assert on(master, "m1") == on(master, "m2") == set()
    assert master._state.place_of == {} and master._state.moving == set()


def test_machine_keeps_remaining_containers_when_draining_ends(master: Master) -> None:
    ran = [run(master, f"r{number}") for number in range(MOVES + 1)]
    master.handle(joined("m2", 4))
    left = leaves(master.handle(SettingsChanged("m1", DRAINING)))
    master.handle(SettingsChanged("m1", MachineSettings()))
    for container in left:
        successor = started(master.handle(ContainerLost(container, GONE, NOW))).spec.id
        assert master.handle(ContainerReady(successor, 43)) == []
    assert on(master, "m1") == {ran[-1]}


def test_moved_container_that_can_never_start_closes_its_place(master: Master) -> None:
    first = run(master, "r1")
    master.handle(joined("m2"))
    master.handle(SettingsChanged("m1", DRAINING))
    successor = started(master.handle(ContainerLost(first, GONE, NOW))).spec.id
    (close,) = master.handle(ContainerLost(successor, InvalidParameter("no such planner"), NOW))
    assert isinstance(close, Close) and master._state.moving == set()


# -- settings ----------------------------------------------------------------------------------------------------------


def test_machine_that_rejoins_keeps_its_settings(master: Master) -> None:
    limits = MachineSettings({"zone": "a"}, max_containers=1)
    master.handle(SettingsChanged("m1", limits))
    master.handle(MachineLeft("m1"))
    master.handle(joined("m1"))
    assert master.machines["m1"].settings == limits


def test_containers_over_a_lowered_limit_stay(master: Master) -> None:
    ran = {run(master, f"r{number}") for number in range(3)}
    assert master.handle(SettingsChanged("m1", MachineSettings(max_containers=1, oversubscription=0.25))) == []
    assert on(master, "m1") == ran
    with pytest.raises(Unavailable):
        master.handle(PlaceRequested(robot_request("r9", cores=0.25)))


def test_raised_limit_admits_a_waiting_place(master: Master) -> None:
    master.handle(joined("m2", 1))
    master.handle(SettingsChanged("m2", MachineSettings(max_containers=0)))
    run(master, "r1")
    assert master.handle(MachineLeft("m1")) == []
    assert started(master.handle(SettingsChanged("m2", MachineSettings()))).machine == "m2"


def test_invalid_settings_change_nothing(master: Master) -> None:
    with pytest.raises(InvalidParameter):
        master.handle(SettingsChanged("m1", MachineSettings(max_containers=-1)))
    assert master.machines["m1"].settings == MachineSettings()
    with pytest.raises(NotFound, match="m1"):
        master.handle(SettingsChanged("m9", MachineSettings()))


# -- labels ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("balancer", [FirstFit, SameMap])
def test_request_with_labels_gets_a_machine_with_them(balancer: Any) -> None:
    master = Master(balancer())
    master.handle(joined("m1"))
    master.handle(joined("m2", labels={"gpu": "yes"}))
    run(master, "r0")
    assert started(master.handle(PlaceRequested(robot_request("r1", labels={"gpu": "yes"})))).machine == "m2"
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"})))
    assert started(master.handle(PlaceRequested(robot_request("r2", labels={"zone": "a"})))).machine == "m1"


def test_missing_labels_error_names_the_closest_machine(master: Master) -> None:
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"})))
    master.handle(joined("m2"))
    with pytest.raises(Unavailable, match="'m1' is closest, but lacks gpu=yes"):
        master.handle(PlaceRequested(robot_request("r1", labels={"zone": "a", "gpu": "yes"})))
    assert master.places == {}


def test_full_machine_with_the_labels_is_reported_as_full(master: Master) -> None:
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"}, max_containers=0)))
    master.handle(joined("m2"))
    with pytest.raises(Unavailable, match="no machine with labels zone=a has room"):
        master.handle(PlaceRequested(robot_request("r1", labels={"zone": "a"})))


def test_container_with_labels_moves_only_to_a_machine_with_them(master: Master) -> None:
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"})))
    first = run(master, "r1", labels={"zone": "a"})
    master.handle(joined("m2"))
    assert master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"}, draining=True))) == []
    assert leaves(master.handle(SettingsChanged("m2", MachineSettings({"zone": "a"})))) == [first]


def test_planning_with_labels_has_its_own_place(master: Master) -> None:
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"})))
    anywhere = PlaceRequest("ann", MapVersion("house", "v1"), 1.0)
    there = PlaceRequest("ann", MapVersion("house", "v1"), 1.0, labels={"zone": "a"})
    assert started(master.handle(PlaceRequested(anywhere))).place != started(master.handle(PlaceRequested(there))).place


# -- removal -----------------------------------------------------------------------------------------------------------


def test_empty_machine_is_removed_and_rejoins_when_admitted(master: Master) -> None:
    master.handle(SettingsChanged("m1", MachineSettings({"zone": "a"})))
    master.handle(RemovalRequested("m1"))
    assert master.machines == {}
    with pytest.raises(NotPermitted, match="removed"):
        master.handle(joined("m1"))
    master.handle(MachineAdmitted("m1"))
    master.handle(joined("m1"))
    assert master.machines["m1"].settings == MachineSettings()


def test_machine_with_containers_is_removed_by_force_only(master: Master) -> None:
    run(master, "r1")
    master.handle(joined("m2"))
    with pytest.raises(Conflict, match="runs 1 container"):
        master.handle(RemovalRequested("m1"))
    assert started(master.handle(RemovalRequested("m1", force=True))).machine == "m2"
    with pytest.raises(NotFound):
        master.handle(RemovalRequested("m1", force=True))


# -- round trips -------------------------------------------------------------------------------------------------------


def test_robot_is_placed_on_the_machine_with_its_short_round_trip() -> None:
    master = Master(SameMap())
    far = Heartbeat(0.0, 0, [], round_trips={"other": 0.09})
    for name in ("m1", "m2"):
        master.handle(joined(name))
        master.handle(MachineMeasured(name, far))
    first = run(master, "r1")
    master.handle(RobotTimed("robot:ann/r1", 0.001))
    near = master.places["robot:ann/r1"].machine
    assert near is not None and master.machines[near].served == {first: 0.001}
    master.handle(MachineMeasured(near, far))
    assert master.machines[near].round_trip == pytest.approx((0.09 + 0.001) / 2)
    master.handle(PlaceReleased("robot:ann/r1"))
    assert master.machines[near].served == {}
    for name in ("m1", "m2"):
        cpu = 1.0 if name == near else 0.5
        master.handle(MachineMeasured(name, Heartbeat(cpu, 0, [], round_trips={"other": 0.09})))
    start = started(master.handle(PlaceRequested(robot_request("r1"))))
    assert start.machine == near, "its own round trip has more weight"
    assert master.handle(RobotTimed("robot:ann/nobody", 0.001)) == []


# -- reports -----------------------------------------------------------------------------------------------------------


def test_impossible_load_is_refused_and_that_of_a_lost_machine_dropped(master: Master) -> None:
    with pytest.raises(InvalidParameter, match="'m1' reports"):
        master.handle(MachineMeasured("m1", Heartbeat(-1.0, 0, [])))
    master.handle(MachineMeasured("m1", Heartbeat(1.5, 1 << 20, [ContainerLoad("c1", 1.0, 1 << 19)])))
    machine = master.machines["m1"]
    assert (machine.cpu, machine.memory_used, list(machine.loads)) == (1.5, 1 << 20, ["c1"])
    assert master.handle(MachineMeasured("m9", Heartbeat(-1.0, 0, []))) == []


def test_machine_may_report_only_on_its_own_containers(master: Master) -> None:
    first = run(master, "r1")
    for report in (ContainerLaunched("m2", first, 7), ContainerLost(first, GONE, NOW, "m2")):
        with pytest.raises(NotPermitted, match="another machine"):
            master.handle(report)
    assert master.places["robot:ann/r1"].pid == 42
    assert master.handle(ContainerLost("c99", GONE, NOW, "m2")) == [], "a container that was replaced"

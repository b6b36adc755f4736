"""A decision does not ask the balancer again for a size that no machine had room for."""

from collections.abc import Iterator
from typing import Any

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.events import ContainerReady, MachineLeft, MapChanged, PlaceReleased, PlaceRequested, SettingsChanged
from engine.master.machine import Machine
from engine.master.master import Master
from engine.master.orders import Start
from engine.master.places import Place, PlaceRequest
from engine.master.queueing import FullMachines
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from tests.support.engine.placing import joined
from tests.support.engine.specs import robot_config, robot_request

ROBOTS = 10


class CountingFirstFit(FirstFit):
    """Counts how often it is asked."""

    asked = 0

    def choose(self, spec: ContainerSpec) -> Machine | None:
        self.asked += 1
        return super().choose(spec)


@pytest.fixture
def balancer() -> CountingFirstFit:
    return CountingFirstFit()


@pytest.fixture
def master(balancer: CountingFirstFit) -> Master:
    made = Master(balancer)
    made.handle(joined("m1", 8, memory=1 << 32))
    return made


def run(master: Master, robot: str, **fields: Any) -> None:
    [start] = master.handle(PlaceRequested(robot_request(robot, **fields)))
    assert isinstance(start, Start)
    master.handle(ContainerReady(start.spec.id, 42))


def test_larger_sizes_with_the_same_labels_are_refused() -> None:
    full, labelled = FullMachines(), {"zone": "a"}
    assert not full.refuse(robot_request(cores=8.0))
    full.note(robot_request(cores=2.0))
    assert full.refuse(Place(robot_request(cores=2.0))) and full.refuse(robot_request(cores=4.0))
    assert not full.refuse(robot_request(cores=1.0)) and not full.refuse(robot_request(cores=4.0, labels=labelled))
    resized = Place(robot_request(cores=2.0), resized=1.0)
    assert not full.refuse(resized), "its next container is smaller"
    full.note(resized)
    assert full.refuse(robot_request(cores=1.0))


def test_a_drained_machine_without_another_asks_once(master: Master, balancer: CountingFirstFit) -> None:
    for number in range(ROBOTS):
        run(master, f"r{number}")
    balancer.asked = 0
    master.handle(SettingsChanged("m1", MachineSettings(draining=True)))
    assert balancer.asked == 1


def test_places_that_wait_ask_once_for_each_set_of_labels(master: Master, balancer: CountingFirstFit) -> None:
    labels = {"zone": "a"}
    master.handle(joined("m2", 8, memory=1 << 32, labels=labels))
    for number in range(ROBOTS):
        run(master, f"r{number}")
        run(master, f"a{number}", labels=labels)
    master.handle(MachineLeft("m2"))
    balancer.asked = 0
    master.handle(PlaceReleased("robot:ann/r0"))
    assert balancer.asked == 1
    assert len(master.handle(joined("m3", 8, memory=1 << 32, labels=labels))) == ROBOTS


def test_only_places_of_a_map_are_examined_when_it_changes(monkeypatch: pytest.MonkeyPatch, master: Master) -> None:
    examined: list[str] = []

    def examine(request: PlaceRequest, event: MapChanged) -> PlaceRequest:
        examined.append(request.key)
        return request

    def requests() -> Iterator[PlaceRequest]:
        zones = {"keepout_filter": MapVersion("zones", "v1")}
        for number in range(ROBOTS):
            yield PlaceRequest("ann", MapVersion("depot", "v1"), 1.0, robot_config(f"d{number}"))
        yield PlaceRequest("ann", MapVersion("zones", "v1"), 1.0, robot_config("z", masks=zones))
        yield PlaceRequest("ann", MapVersion("house", "v1"), 1.0, robot_config("h", masks=zones))

    for request in requests():
        master.handle(PlaceRequested(request))
    monkeypatch.setattr("engine.master.master.with_version", examine)
    master.handle(MapChanged(MapVersion("zones", "v2")))
    assert examined == ["robot:ann/z", "robot:ann/h"]
    master.handle(PlaceReleased("robot:ann/z"))
    master.handle(MapChanged(MapVersion("zones", "v3")))
    assert examined[2:] == ["robot:ann/h"]

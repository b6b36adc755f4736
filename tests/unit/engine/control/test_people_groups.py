"""Groups of robots that track people, and the places of their coordinators: real links, no processes."""

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.control.group_places import LONGEST_RETRY, PEOPLE_LINGER, RETRY, PeopleGroups
from engine.control.master_driver import CloudListener, MasterDriver
from engine.control.views import PeopleGroupView
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.protocols import control_link, robot_link
from engine.protocols.refusals import Refusal
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.people_coordination import GetPeopleCountsResponse, PeopleState, ZoneCount
from ppaas.people.settings import PeopleSettings
from storage.memory.store import MemoryStore
from storage.people import MapPeople
from storage.records import Limits
from tests.support.engine.at_once import at_once
from tests.support.engine.fake_machine import FakeMachine, FarContainer
from tests.support.engine.specs import HOUSE, coordinator_request, robot_request
from tests.support.waiting import until

KEY = "people:ann/house"
GONE = Unavailable("it has gone")


def seeing(robot: str = "tb1", **fields: object) -> PlaceRequest:
    """Return a request for a robot with a torso detector."""
    return robot_request(robot, cores=0.25, parameters={"torso_detector": {}}, **fields)  # type: ignore[arg-type]


class Groups(CloudListener):
    """Groups of a cloud, as its engine connects them, by a clock that the test sets."""

    def __init__(self, folder: Path) -> None:
        self.store = MemoryStore()
        self.clock = ManualClock(100.0)
        master = Master(FirstFit(), Quotas(Quota(containers=6)))
        self.service = MasterDriver(master, CheckpointSelection(self.store), folder, "secret", self)
        self.people = PeopleGroups(self.service, self.clock)
        self.robot: FarContainer | None = None

    def place_opened(self, key: str) -> None:
        self.people.places.place_opened(key)

    def is_open(self) -> bool:
        return self.service.place(KEY) is not None

    def connect(self, request: PlaceRequest) -> None:
        """Open the place of a robot, as if its container were ready."""
        self.service.open_place(request).container = "c"

    async def after(self, seconds: float) -> None:
        self.clock.advance(seconds)
        await self.people.places.step()


@pytest.fixture
async def groups(tmp_path: Path) -> AsyncIterator[Groups]:
    made = Groups(tmp_path)
    await made.service.start()
    yield made
    made.people.places.close()
    await made.service.close()


@pytest.fixture
async def machine(groups: Groups, tmp_path: Path) -> AsyncIterator[FakeMachine]:
    joined = await FakeMachine.join(tmp_path)
    await joined.welcome
    yield joined
    await joined.leave()


async def ordered(groups: Groups, machine: FakeMachine) -> control_link.StartContainer:
    """Start the container of a robot; return the order to start that of its coordinator."""
    place = groups.service.open_place(seeing())
    groups.robot = await machine.boot(await machine.started())
    await place.ready(10)
    await groups.after(0.0)
    return await machine.started()


async def answer(far: FarContainer, service: str, answered: bytes) -> dict[str, object]:
    """Answer a call; return its request."""
    call = await far.next()
    assert isinstance(call, robot_link.ServiceCall) and call.service == f"people_coordinator/{service}"
    far.stream.write(robot_link.ServiceAnswer(call.call, answered))
    return dict(json.loads(call.payload))


async def test_the_first_robot_that_tracks_people_brings_a_coordinator_and_the_last_takes_it(groups: Groups) -> None:
    groups.connect(robot_request("blind"))
    groups.connect(robot_request("tb0", parameters={"follow_person": {}}))
    await groups.after(0.0)
    assert not groups.is_open() and at_once(groups.people.views()) == []
    place = groups.service.open_place(seeing())
    await groups.after(0.0)
    assert not groups.is_open(), "the robot starts first"
    place.container = "c"
    await groups.after(0.0)
    assert groups.service.request_of(KEY) == coordinator_request()
    await groups.service.close_place("robot:ann/blind", GONE)
    groups.connect(seeing("tb2"))
    await groups.after(0.0)
    assert at_once(groups.people.views()) == [PeopleGroupView("ann", "house", ("tb1", "tb2"), "starting")]
    for robot in ("tb1", "tb2"):
        await groups.service.close_place(f"robot:ann/{robot}", GONE)
        await groups.after(PEOPLE_LINGER * 0.9)
    assert groups.is_open(), "a robot whose file was changed comes back at once"
    await groups.after(PEOPLE_LINGER)
    assert not groups.is_open() and at_once(groups.people.views()) == []


async def test_each_user_and_map_has_a_group_and_new_maps_have_none(groups: Groups) -> None:
    others = [seeing(user="bob"), seeing("tb2", version=MapVersion("depot", "v1")), seeing("tb3", new_map="attic")]
    for request in others:
        groups.connect(request)
    await groups.after(0.0)
    assert [(view.user, view.map, view.robots) for view in at_once(groups.people.views())] == [
        ("ann", "depot", ("tb2",)),
        ("bob", "house", ("tb1",)),
    ]


async def test_robots_work_on_while_the_quota_refuses_a_coordinator_and_get_it_later(groups: Groups) -> None:
    groups.service.set_limits("ann", Limits(containers=1))
    groups.connect(seeing())
    await groups.after(0.0)
    (view,) = at_once(groups.people.views())
    assert view.state == "refused" and "1 containers" in view.reason
    with pytest.raises(Unavailable, match="1 containers"):
        await groups.people.people("ann", "house")
    assert groups.service.place("robot:ann/tb1") is not None
    groups.service.set_limits("ann", Limits(containers=2))
    await groups.after(RETRY * 0.5)
    assert not groups.is_open()
    await groups.after(RETRY)
    assert groups.is_open()


async def test_a_coordinator_starts_with_the_stored_settings_and_answers(groups: Groups, machine: FakeMachine) -> None:
    settings = PeopleSettings(rule="longest_seen", followed_at_once=2)
    groups.store.put_people_settings(MapPeople("ann", "house", settings))
    far = await machine.boot(await ordered(groups, machine))
    assert (far.spec.people, far.spec.map, far.spec.kind) == (settings, HOUSE, "coordinator")
    await until(lambda: at_once(groups.people.views())[0].state == "ready")
    assert at_once(groups.people.views()) == [PeopleGroupView("ann", "house", ("tb1",), "ready")]
    state = PeopleState(Header(frame_id="map"), 3)
    found, _ = await asyncio.gather(groups.people.people("ann", "house"), answer(far, "get_people", encode(state)))
    assert found == state
    counts = [ZoneCount("hall", 3600, 5)]
    answered = answer(far, "get_people_counts", encode(GetPeopleCountsResponse(counts)))
    numbers, asked = await asyncio.gather(groups.people.counts("ann", "house", 60), answered)
    assert (numbers, asked) == (counts, {"since": 60})
    changed = PeopleSettings(rule="named", targets=[4])
    configured = answer(far, "configure_people", b"{}")
    _, request = await asyncio.gather(groups.people.configure("ann", "house", changed), configured)
    assert json.loads(str(request["settings"]))["targets"] == [4]
    await groups.service.close_place("robot:ann/tb1", GONE)
    await groups.after(0.0)
    configured = answer(far, "configure_people", b"{}")
    _, request = await asyncio.gather(groups.people.configure("ann", "house", settings), configured)
    assert json.loads(str(request["settings"]))["targets"] == [], "it outlives its robots, which may come back"
    await far.stream.close()


async def test_an_adopted_coordinator_takes_settings_before_its_robots_are_back(
    groups: Groups, machine: FakeMachine
) -> None:
    groups.service.open_place(coordinator_request())
    far = await machine.boot(await machine.started())
    settings = PeopleSettings(rule="longest_seen")
    configured = answer(far, "configure_people", b"{}")
    _, request = await asyncio.gather(groups.people.configure("ann", "house", settings), configured)
    assert json.loads(str(request["settings"]))["rule"] == "longest_seen"
    await far.stream.close()


async def test_coordinators_end_with_their_map(groups: Groups) -> None:
    for request in (coordinator_request(), seeing("tb2", version=MapVersion("depot", "v1"))):
        groups.connect(request)
    await groups.after(0.0)
    await groups.people.places.close_map("house")
    assert not groups.is_open()
    assert groups.service.place("people:ann/depot") is not None, "other maps keep theirs"


async def test_a_coordinator_whose_settings_it_refuses_is_tried_again_once_they_change(
    groups: Groups, machine: FakeMachine
) -> None:
    refused = Refusal("invalid-input", "no rule 'guess'")
    machine.tell(control_link.LaunchFailed((await ordered(groups, machine)).spec.id, refused))
    await until(lambda: not groups.is_open())
    await groups.after(0.0)
    (view,) = at_once(groups.people.views())
    assert (view.state, view.reason) == ("refused", "no rule 'guess'")
    await groups.after(RETRY)
    machine.tell(control_link.LaunchFailed((await machine.started()).spec.id, refused))
    await until(lambda: not groups.is_open())
    await groups.after(0.0)
    await groups.after(RETRY)
    assert not groups.is_open(), "each time later"
    await groups.people.configure("ann", "house", PeopleSettings())
    await groups.after(0.0)
    assert groups.is_open()


async def test_a_coordinator_that_fails_for_days_is_tried_again_each_minute(groups: Groups) -> None:
    groups.connect(seeing())
    await groups.after(0.0)
    for _ in range(1100):  # more doublings than a float can hold
        await groups.service.close_place(KEY, GONE)
        await groups.after(0.0)
        assert not groups.is_open()
        await groups.after(LONGEST_RETRY)
        assert groups.is_open()


async def test_without_robots_nothing_is_known_and_nothing_to_configure(groups: Groups) -> None:
    with pytest.raises(Unavailable, match="connect one with a detector"):
        await groups.people.people("ann", "house")
    await groups.people.configure("ann", "house", PeopleSettings())


async def test_an_adopted_coordinator_without_robots_is_closed(groups: Groups) -> None:
    groups.service.open_place(coordinator_request())
    await groups.after(0.0)
    assert groups.is_open()
    await groups.after(PEOPLE_LINGER)
    assert not groups.is_open()

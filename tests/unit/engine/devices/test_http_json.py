import pytest
from starlette.responses import JSONResponse, RedirectResponse, Response

from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.errors import InvalidInput, NotPermitted, Unavailable
from tests.support.buildings import LEVELS, LiftServer
from tests.support.device_states import running
from tests.support.endpoints.serving import serve
from tests.support.waiting import until

LOCAL = DeviceHosts(["127.0.0.1"])


def lift_at(port, hosts=LOCAL, query="?floors=L1:1,L2:2,L3:3&poll=0.1"):
    return open_lift(LiftSettings(lift="A", device=f"http://127.0.0.1:{port}/lift{query}"), LEVELS, hosts)


async def test_a_lift_is_sent_to_a_floor_and_let_go():
    server = LiftServer()
    async with serve(server) as port:
        device = lift_at(port)
        async with running(device) as states:
            await device.send(LiftRequest("A", "s", "L3"))
            await until(lambda: states and (states[-1].floor, states[-1].door) == ("L3", "open"))
            assert (states[-1].session, states[-1].floors, states[-1].lift) == ("s", ("L1", "L2", "L3"), "A")
            await device.send(EndSession("A", "s"))
            await until(lambda: states[-1].session == "")
    assert server.orders == [{"session": "s", "floor": "3", "door": "open"}, {"session": "s", "end": True}]


async def test_a_door_is_opened_and_closed():
    server = LiftServer()
    async with serve(server) as port:
        url = f"http://127.0.0.1:{port}/door?poll=0.1"
        device = open_door(DoorSettings(floor="L1", door="main", device=url), LOCAL)
        async with running(device) as states:
            await device.send(DoorRequest("L1", "main", "s", "open"))
            await until(lambda: states and states[-1].mode == "open")
            assert (states[-1].floor, states[-1].door) == ("L1", "main")
            await device.send(DoorRequest("L1", "main", "s", "closed"))
            await until(lambda: states[-1].mode == "closed")


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (Response(status_code=500), "answered GET with 500"),
        (RedirectResponse("http://127.0.0.1:1/"), "answered GET with 307"),
        (Response("no JSON"), "returned no state"),
        (JSONResponse({"floor": "1", "door": "ajar"}), "returned no state"),
        (Response(b" " * 100_000), "returned more than"),
    ],
    ids=["500", "redirect", "text", "door", "size"],
)
async def test_a_server_that_returns_no_state_is_a_lost_device(answer, text):
    server = LiftServer()
    server.answer = answer
    async with serve(server) as port:
        with pytest.raises(Unavailable, match=text):
            await lift_at(port).run(lambda _state: None)


async def test_a_server_that_is_away_is_a_lost_device():
    with pytest.raises(Unavailable, match="did not answer"):
        await lift_at(1).run(lambda _state: None)


async def test_a_device_that_was_lost_is_reached_again():
    server = LiftServer()
    server.answer = Response(status_code=500)
    async with serve(server) as port:
        device = lift_at(port)
        with pytest.raises(Unavailable):
            await device.run(lambda _state: None)
        server.answer = None
        async with running(device) as states:
            await until(lambda: states)


async def test_a_host_that_is_not_listed_is_not_connected_to():
    server = LiftServer()
    async with serve(server) as port:
        for hosts in (DeviceHosts(), DeviceHosts(["127.0.0.1:1"]), DeviceHosts(["10.0.0.0/8"])):
            with pytest.raises(NotPermitted, match="has not listed"):
                await lift_at(port, hosts).send(EndSession("A", "s"))
    assert server.orders == []


@pytest.mark.parametrize("query", ["?poll=0", "?poll=x", "?pool=1", "?floors=L1", "?floors=L1:1,L2:1"])
async def test_wrong_options_are_refused(query):
    with pytest.raises(InvalidInput):
        lift_at(1, query=query)

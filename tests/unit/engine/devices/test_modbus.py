import pytest

from engine.devices import modbus
from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.errors import InvalidInput, NotPermitted, Unavailable
from tests.support.buildings import LEVELS
from tests.support.device_states import running
from tests.support.modbus import Plc
from tests.support.waiting import until

LOCAL = DeviceHosts(["127.0.0.1"])


def lift_at(port, hosts=LOCAL, query="?base=100&poll=0.05", unit="/1"):
    return open_lift(LiftSettings(lift="A", device=f"modbus://127.0.0.1:{port}{unit}{query}"), LEVELS, hosts)


async def test_a_lift_is_sent_to_a_floor_and_let_go():
    async with Plc().serving() as plc:
        device = lift_at(plc.port)
        async with running(device) as states:
            await until(lambda: states)
            await device.send(LiftRequest("A", "s", "L3"))
            await until(lambda: (states[-1].floor, states[-1].door) == ("L3", "open"))
            assert (states[-1].session, states[-1].mode, states[-1].motion) == ("s", "agv", "stopped")
            plc.mode = 3
            await until(lambda: states[-1].mode == "fire")
            plc.mode = 77
            await until(lambda: states[-1].mode == "unknown")
            await device.send(EndSession("A", "s"))
            await until(lambda: states[-1].session == "")
    assert plc.counters == [1, 2]


async def test_a_session_that_this_process_has_not_asked_for_is_foreign():
    async with Plc().serving() as plc:
        plc.lift.request(LiftRequest("A", "plc", "L1"), plc.lift._now)
        async with running(lift_at(plc.port)) as states:
            await until(lambda: states)
            assert states[0].session == modbus.FOREIGN


async def test_a_door_is_opened_and_closed():
    async with Plc().serving() as plc:
        url = f"modbus://127.0.0.1:{plc.port}/2?base=100&poll=0.05"
        device = open_door(DoorSettings(floor="L1", door="main", device=url), LOCAL)
        async with running(device) as states:
            await until(lambda: states)
            await device.send(DoorRequest("L1", "main", "s", "open"))
            await until(lambda: states[-1].mode == "open")
            await device.send(DoorRequest("L1", "main", "s", "closed"))
            await until(lambda: states[-1].mode == "closed")


async def test_a_plc_whose_counter_stands_still_is_silent(monkeypatch):
    monkeypatch.setattr(modbus, "FROZEN", 0.0)
    async with Plc().serving() as plc, running(lift_at(plc.port)) as states:
        plc.counts = False
        asked = plc.reads
        await until(lambda: plc.reads > asked + 3)
        number = len(states)
        await until(lambda: plc.reads > asked + 6)
        assert len(states) == number
        monkeypatch.setattr(modbus, "FROZEN", 5.0)
        plc.counts = True
        await until(lambda: len(states) > number)


async def test_a_plc_that_was_away_is_reached_again():
    plc = Plc()
    async with plc.serving():
        pass
    device = lift_at(plc.port)
    with pytest.raises(Unavailable, match="cannot be connected to"):
        await device.run(lambda _state: None)
    with pytest.raises(Unavailable, match="is not connected"):
        await device.send(EndSession("A", "s"))
    async with plc.serving(), running(device) as states:
        await until(lambda: states)


async def test_registers_that_a_plc_lacks_are_reported():
    async with Plc().serving() as plc:
        with pytest.raises(Unavailable, match="answered with the exception 2"):
            await lift_at(plc.port, query="?base=500").run(lambda _state: None)


async def test_a_host_that_is_not_listed_is_not_connected_to():
    with pytest.raises(NotPermitted):
        await lift_at(1, DeviceHosts()).run(lambda _state: None)


@pytest.mark.parametrize(("query", "unit"), [("?floors=L1:ground", "/1"), ("?base=-1", "/1"), ("", "/300"), ("", "/x")])
def test_a_url_that_is_not_valid_is_refused(query, unit):
    with pytest.raises(InvalidInput):
        lift_at(1, query=query, unit=unit)

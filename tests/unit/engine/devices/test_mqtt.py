"""Devices over a broker that is not ours: Debian's mosquitto."""

import asyncio
import contextlib
import json

import aiomqtt
import msgspec
import pytest

from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.simulated import SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.clock import epoch
from ppaas.errors import InvalidInput, MalformedMessage, NotPermitted, Unavailable
from tests.support.buildings import LEVELS, QUICK
from tests.support.device_states import running
from tests.support.vda5050.mosquitto import Mosquitto
from tests.support.waiting import until

LOCAL = DeviceHosts(["127.0.0.0/8"])


@pytest.fixture(scope="module")
def broker(tmp_path_factory):
    mosquitto = Mosquitto(tmp_path_factory.mktemp("mosquitto"))
    mosquitto.start()
    yield mosquitto
    mosquitto.kill()


def lift_at(port, hosts=LOCAL, path="/site/lifts/A"):
    return open_lift(LiftSettings(lift="A", device=f"mqtt://127.0.0.1:{port}{path}"), LEVELS, hosts)


@contextlib.asynccontextmanager
async def gateway(port, lift, orders):
    """Serve a lift at the broker: it obeys orders, and publishes its state ten times a second."""
    async with aiomqtt.Client("127.0.0.1", port) as client:
        await client.subscribe("site/lifts/A/order")

        async def obey():
            async for message in client.messages:
                order = json.loads(message.payload)
                orders.append(order)
                if order.get("end"):
                    lift.end(EndSession("A", order["session"]), epoch())
                else:
                    lift.request(LiftRequest("A", order["session"], order["floor"]), epoch())

        async def publish():
            while True:
                await client.publish("site/lifts/A/state", msgspec.json.encode(lift.state(epoch())))
                await asyncio.sleep(0.1)

        tasks = [asyncio.create_task(obey()), asyncio.create_task(publish())]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


async def test_a_lift_is_sent_to_a_floor_and_let_go(broker):
    orders = []
    async with gateway(broker.port, SimulatedLift("A", LEVELS, epoch(), QUICK), orders):
        device = lift_at(broker.port)
        async with running(device) as states:
            await until(lambda: states)
            await device.send(LiftRequest("A", "s", "L3"))
            await until(lambda: (states[-1].floor, states[-1].door, states[-1].session) == ("L3", "open", "s"))
            await device.send(EndSession("A", "s"))
            await until(lambda: states[-1].session == "")
    assert [order["headerId"] for order in orders] == [1, 2]
    assert orders[0]["timestamp"].endswith("Z")


async def test_a_retained_state_is_not_taken_for_a_new_one(broker):
    async with aiomqtt.Client("127.0.0.1", broker.port) as client:
        await client.publish("site/doors/main/state", b'{"mode": "open"}', retain=True)
        device = open_door(
            DoorSettings(floor="L1", door="main", device=f"mqtt://127.0.0.1:{broker.port}/site/doors/main"), LOCAL
        )
        await client.subscribe("site/doors/main/order")
        async with running(device) as states:
            order = DoorRequest("L1", "main", "s", "open")
            while True:
                with contextlib.suppress(Unavailable):
                    await device.send(order)
                    break
                await asyncio.sleep(0.02)
            message = await anext(aiter(client.messages))
            assert json.loads(message.payload)["mode"] == "open"
            await client.publish("site/doors/main/state", b'{"mode": "moving"}')
            await until(lambda: states)
            assert [state.mode for state in states] == ["moving"]


async def test_what_is_no_state_ends_the_connection(broker):
    device = lift_at(broker.port, path="/site/bad")
    task = asyncio.create_task(device.run(lambda _state: None))
    async with aiomqtt.Client("127.0.0.1", broker.port) as client:
        while not task.done():
            await client.publish("site/bad/state", b'{"floor": 3}')
            await asyncio.sleep(0.05)
    with pytest.raises(MalformedMessage, match="no state of a device"):
        await task


async def test_a_broker_that_is_away_or_not_listed_is_reported():
    with pytest.raises(Unavailable, match=r"127\.0\.0\.1:1 cannot be used"):
        await lift_at(1).run(lambda _state: None)
    with pytest.raises(NotPermitted):
        await lift_at(1, DeviceHosts()).run(lambda _state: None)
    with pytest.raises(Unavailable, match="not connected"):
        await lift_at(1).send(EndSession("A", "s"))


@pytest.mark.parametrize("path", ["", "/", "/a/+/b", "/a/%23"])
def test_topics_that_are_not_valid_are_refused(path):
    with pytest.raises(InvalidInput, match="beginning of its topics"):
        lift_at(1, path=path)

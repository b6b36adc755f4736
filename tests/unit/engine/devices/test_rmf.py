"""Lifts and doors of Open-RMF over Zenoh, by a peer that codes keys and tokens by itself."""

import asyncio
import json
import socket

import pytest
import zenoh

from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.errors import InvalidInput, NotPermitted, Unavailable
from tests.support.buildings import LEVELS
from tests.support.device_states import running
from tests.support.ros2.zenoh_peer import Peer
from tests.support.waiting import until

LOCAL = DeviceHosts(["127.0.0.1"])
LIFT_STATE, LIFT_REQUEST = "rmf_lift_msgs/msg/LiftState", "rmf_lift_msgs/msg/LiftRequest"
DOOR_STATE, DOOR_REQUEST = "rmf_door_msgs/msg/DoorState", "rmf_door_msgs/msg/DoorRequest"


@pytest.fixture(scope="module")
def port():
    """Port of a router of Zenoh."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        number = listener.getsockname()[1]
    config = zenoh.Config()
    listening = {"mode": "router", "listen/endpoints": [f"tcp/127.0.0.1:{number}"], "scouting/multicast/enabled": False}
    for key, value in listening.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config):
        yield number


def lift_at(port, hosts=LOCAL, tail="/lift_1?floors=L1:ground"):
    return open_lift(LiftSettings(lift="A", device=f"rmf://127.0.0.1:{port}{tail}"), LEVELS, hosts)


async def send(device, order):
    """Send an order as soon as the device is connected."""
    while True:
        try:
            return await device.send(order)
        except Unavailable:
            await asyncio.sleep(0.02)


def lift_state(**members):
    usual = {"lift_name": "lift_1", "available_floors": ["ground", "L2"], "current_floor": "ground", "current_mode": 2}
    return usual | members


async def test_a_lift_reports_and_is_requested(port):
    peer = await asyncio.to_thread(Peer, f"tcp/127.0.0.1:{port}", "lift_adapter")
    requests = []
    peer.subscribe("lift_requests", LIFT_REQUEST, requests.append)
    publish = peer.publisher("lift_states", LIFT_STATE)
    device = lift_at(port)
    async with running(device) as states:
        await send(device, EndSession("A", "s"))

        async def report(**members):
            number = len(states)
            while len(states) == number:
                publish(lift_state(lift_name="another"))
                publish(lift_state(**members))
                await asyncio.sleep(0.02)
            return states[-1]

        state = await report(door_state=2, session_id="s")
        assert (state.lift, state.floor, state.door, state.motion) == ("A", "L1", "open", "stopped")
        assert (state.mode, state.session, state.floors) == ("agv", "s", ("L1", "L2"))
        await asyncio.sleep(0.2)
        states.clear()
        unknown = await report(door_state=1, motion_state=3, current_mode=3)
        assert (unknown.door, unknown.motion, unknown.mode) == ("moving", "up", "fire")

        def has(**members):
            return any(members.items() <= request.items() for request in requests)

        while not has(request_type=1, destination_floor="ground", door_state=2, session_id="s", lift_name="lift_1"):
            await device.send(LiftRequest("A", "s", "L1"))
            await asyncio.sleep(0.02)
        while not has(request_type=0, session_id="s"):
            await device.send(EndSession("A", "s"))
            await asyncio.sleep(0.02)
    await asyncio.to_thread(peer.close)


async def test_a_door_reports_and_is_requested(port):
    peer = await asyncio.to_thread(Peer, f"tcp/127.0.0.1:{port}", "door_adapter")
    requests = []
    peer.subscribe("adapter_door_requests", DOOR_REQUEST, requests.append)
    publish = peer.publisher("door_states", DOOR_STATE)
    url = f"rmf://127.0.0.1:{port}/main_door?requests=adapter_door_requests"
    device = open_door(DoorSettings(floor="L1", door="main", device=url), LOCAL)
    async with running(device) as states:
        while not requests:
            await send(device, DoorRequest("L1", "main", "s", "open"))
            await asyncio.sleep(0.02)
        assert (requests[0]["door_name"], requests[0]["requester_id"]) == ("main_door", "s")
        assert requests[0]["requested_mode"] == {"value": 2}
        while not states:
            publish({"door_name": "main_door", "current_mode": {"value": 3}})
            await asyncio.sleep(0.02)
        assert (states[0].floor, states[0].door, states[0].mode) == ("L1", "main", "offline")
    await asyncio.to_thread(peer.close)


async def test_bytes_that_are_no_message_change_nothing(port):
    peer = await asyncio.to_thread(Peer, f"tcp/127.0.0.1:{port}", "broken")
    publish = peer.publisher("lift_states", LIFT_STATE)
    key = f"0/lift_states/rmf_lift_msgs::msg::dds_::LiftState_/{peer.types.type_hash(LIFT_STATE)}"
    device = lift_at(port)
    async with running(device) as states:
        while not states:
            peer.session.put(key, b"\0\1\2")
            publish(lift_state())
            await asyncio.sleep(0.02)
        await until(lambda: {state.floor for state in states} == {"L1"})
    await asyncio.to_thread(peer.close)


async def test_a_router_that_is_away_or_not_listed_is_reported():
    with pytest.raises(Unavailable, match="cannot be reached"):
        await lift_at(1).run(lambda _state: None)
    with pytest.raises(NotPermitted):
        await lift_at(1, DeviceHosts()).run(lambda _state: None)
    with pytest.raises(Unavailable, match="not connected"):
        await lift_at(1).send(EndSession("A", "s"))


@pytest.mark.parametrize("tail", ["", "/", "/a?release=indigo", "/a?domain=900"])
def test_a_url_that_is_not_valid_is_refused(tail):
    with pytest.raises(InvalidInput):
        lift_at(1, tail=tail)

"""Bare keys and payloads on a Zenoh session of the loopback interface."""

import asyncio
import json
import socket

import zenoh

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.graph import Qos
from robots.bridges.free_fleet.plain_zenoh import PlainZenohTransport
from robots.bridges.zenoh.node import ZenohOptions
from tests.support.waiting import until


def client(endpoint: str) -> zenoh.Session:
    config = zenoh.Config()
    for key, value in {"mode": "client", "connect/endpoints": [endpoint]}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


async def test_topics_and_services_have_their_names_as_keys() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        endpoint = f"tcp/127.0.0.1:{listener.getsockname()[1]}"
    transport = PlainZenohTransport(ZenohOptions(listen=(endpoint,), release="jazzy"))
    await transport.open(lambda: None)
    peer = client(endpoint)
    try:
        heard: list[bytes] = []
        kept = peer.declare_subscriber("tb1/tf", lambda sample: heard.append(sample.payload.to_bytes()))
        publisher = transport.publisher("/tb1/tf", "tf2_msgs/msg/TFMessage", Qos())

        def published() -> object:
            publisher.publish(b"\x01\x02")
            return heard

        await until(published)
        assert heard[0] == b"\x01\x02"

        received: list[bytes] = []
        subscription = transport.subscribe("/tb1/stop", "std_msgs/msg/Empty", Qos(), received.append)

        def stopped() -> object:
            peer.put("tb1/stop", b"now")
            return received

        await until(stopped)
        assert received[0] == b"now"

        async def answer(request: bytes) -> bytes:
            if not request:
                raise MalformedMessage("an empty request")
            return request[::-1]

        served = transport.serve("/tb1/turn", "std_srvs/srv/Trigger", answer)

        def ask(payload: bytes) -> list[bytes]:
            replies = peer.get("tb1/turn", payload=payload, timeout=5.0)
            return [reply.ok.payload.to_bytes() for reply in replies if reply.ok]

        assert await asyncio.to_thread(ask, b"abc") == [b"cba"]
        assert await asyncio.to_thread(ask, b"") == [], "a request that is refused has no answer"
        for part in (publisher, subscription, served):
            part.close()
        assert await asyncio.to_thread(ask, b"abc") == []
        kept.undeclare()
    finally:
        peer.close()
        await transport.close()

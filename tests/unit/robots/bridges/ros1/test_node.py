"""The transport over real sockets, with a master and a node that are independent of it."""

import asyncio
import socket
import struct
import xmlrpc.client
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any

import pytest

from benchmarks.bridge.master_stand_in import MasterStandIn
from ppaas.errors import Conflict, InvalidInput, Unavailable
from ppaas.wire.ros.graph import LATCHED, Kind, Qos
from robots.bridges.ros1 import connections
from robots.bridges.ros1 import node as node_module
from robots.bridges.ros1.connections import NodeConnection
from robots.bridges.ros1.node import Ros1Options, Ros1Transport, node_name
from tests.support.ros1.node import TYPES, Node, frame, pack, unpack
from tests.support.waiting import until

STRING, GRID, GET_MAP = "std_msgs/msg/String", "nav_msgs/msg/OccupancyGrid", "nav_msgs/srv/GetMap"


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_module, "POLL", 0.05)
    monkeypatch.setattr(connections, "FIRST_RETRY", 0.02)


@pytest.fixture
def master() -> Iterator[MasterStandIn]:
    running = MasterStandIn()
    yield running
    running.stop()


@contextmanager
def node(master: MasterStandIn, name: str = "/robot") -> Iterator[Node]:
    running = Node(name, master.uri)
    try:
        yield running
    finally:
        running.close()


@asynccontextmanager
async def opened(master: MasterStandIn, name: str = "bridge") -> AsyncIterator[Ros1Transport]:
    transport = Ros1Transport(Ros1Options(master.uri), name)
    await transport.open(lambda: None)
    try:
        yield transport
    finally:
        await transport.close()


def text(value: str) -> bytes:
    return TYPES.encode(STRING, {"data": value})


async def test_topics_pass_both_ways_and_late_readers_get_what_is_latched(master: MasterStandIn) -> None:
    heard: list[str] = []
    read: list[str] = []
    async with opened(master) as transport:
        latched = transport.publisher("/name", STRING, LATCHED)
        latched.publish(text("office"))
        transport.subscribe("/chatter", STRING, Qos(), lambda data: heard.append(TYPES.decode(STRING, data)["data"]))
        with node(master) as robot:
            say = robot.publisher("/chatter", "std_msgs/String")
            robot.subscribe("/name", "std_msgs/String", lambda message: read.append(message["data"]))
            found = {(one.kind, one.name, one.type, one.node) for one in await graph(transport, 2)}
            assert found == {
                (Kind.PUBLISHER, "/chatter", STRING, "/robot"),
                (Kind.SUBSCRIBER, "/name", STRING, "/robot"),
            }
            await until(lambda: say({"data": "hello"}) or heard)
            await until(lambda: read)
            latched.publish(text("lab"))
            await until(lambda: len(read) == 2)
        assert (heard[0], read) == ("hello", ["office", "lab"])
    assert not any(any(table.values()) for table in (master.publishers, master.subscribers) if "/bridge" in str(table))


async def graph(transport: Ros1Transport, count: int) -> list[Any]:
    await until(lambda: len(transport.entities()) == count)
    return list(transport.entities())


async def test_a_master_that_is_restarted_learns_the_node_again_and_no_message_is_lost(
    master: MasterStandIn, caplog: pytest.LogCaptureFixture
) -> None:
    heard: list[str] = []
    async with opened(master) as transport:
        transport.publisher("/cmd_vel", STRING, Qos())
        transport.subscribe("/odom", STRING, Qos(), lambda data: heard.append(TYPES.decode(STRING, data)["data"]))
        with node(master) as robot:
            say = robot.publisher("/odom", "std_msgs/String")
            robot.subscribe("/cmd_vel", "std_msgs/String", lambda _: None)
            await until(lambda: say({"data": "before"}) or heard)
            await until(lambda: len(transport.publications["/cmd_vel"].peers) == 1)
            master.stop()
            await until(lambda: "does not answer, and is tried again" in caplog.text)
            assert transport.faults().keys() == {"master"}
            say({"data": "without a master"})
            again = MasterStandIn(master.port)
            try:
                await until(
                    lambda: "/bridge" in again.publishers["/cmd_vel"] and "/bridge" in again.subscribers["/odom"]
                )
                assert {(one.kind, one.name) for one in transport.entities()} == {
                    (Kind.PUBLISHER, "/odom"),
                    (Kind.SUBSCRIBER, "/cmd_vel"),
                }, "the robot's nodes do not register again, but are connected"
                await until(lambda: not transport.faults())
                say({"data": "after"})
                await until(lambda: "after" in heard)
                assert "without a master" in heard
                robot.close()
                await graph(transport, 0)
                with node(again) as new:
                    say = new.publisher("/odom", "std_msgs/String")
                    await until(lambda: say({"data": "restarted"}) or "restarted" in heard)
            finally:
                again.stop()


async def test_a_topic_that_was_subscribed_to_without_a_type_gets_that_of_its_publisher(
    master: MasterStandIn,
) -> None:
    async with opened(master) as transport:
        with node(master, "/rostopic") as listener, node(master) as robot:
            listener.master.registerSubscriber("/rostopic", "/odom", "*", listener.uri)
            await until(lambda: "/odom" in transport._known_types)
            assert {(one.kind, one.name, one.type) for one in await graph(transport, 1)} == {
                (Kind.SUBSCRIBER, "/odom", "")
            }
            robot.publisher("/odom", "std_msgs/String")
            assert {one.type for one in await graph(transport, 2)} == {STRING}


async def test_a_registration_that_fails_loses_no_other_and_is_tried_again(master: MasterStandIn) -> None:
    heard: list[str] = []
    with node(master) as robot:
        say = robot.publisher("/odom", "std_msgs/String")
        master.refused.add("/map")
        async with opened(master) as transport:
            transport.publisher("/map", STRING, Qos())
            transport.subscribe("/odom", STRING, Qos(), lambda data: heard.append(TYPES.decode(STRING, data)["data"]))
            await until(lambda: "/bridge" in master.publishers["/map"])
            await until(lambda: say({"data": "hello"}) or heard)


async def test_a_robot_that_is_killed_and_comes_back_is_followed(master: MasterStandIn) -> None:
    heard: list[str] = []
    async with opened(master) as transport:
        transport.subscribe("/odom", STRING, Qos(), lambda data: heard.append(TYPES.decode(STRING, data)["data"]))
        ids = set()
        for life in ("first", "second"):
            with node(master) as robot:
                say = robot.publisher("/odom", "std_msgs/String")
                await until(lambda say=say, life=life: say({"data": life}) or life in heard)
                ids |= {one.id for one in transport.entities() if "http" in one.id}
        assert len(ids) == 2, "a node that restarts is another publisher"


async def test_a_node_ends_right_after_its_topics(master: MasterStandIn) -> None:
    async with opened(master) as transport:
        published = transport.publisher("/a", STRING, Qos())
        await until(lambda: "/bridge" in master.publishers["/a"])
        await asyncio.sleep(0.02)
        published.close()
        await asyncio.wait_for(transport.close(), 10)
    assert not master.publishers["/a"]


async def test_services_are_answered_once_or_often_and_failures_are_told(master: MasterStandIn) -> None:
    async def answer(request: bytes) -> bytes:
        return TYPES.encode(f"{GET_MAP}_Response", {"map": {"info": {"width": 3}}})

    async def fail(request: bytes) -> bytes:
        raise Unavailable("no clone")

    async with opened(master) as transport:
        transport.serve("/static_map", GET_MAP, answer)
        transport.serve("/fail", GET_MAP, fail)
        await until(lambda: len(master.services) == 2)
        with node(master) as robot:
            response = await asyncio.to_thread(robot.call, "/static_map", GET_MAP, {})
            assert response["map"]["info"]["width"] == 3
            with pytest.raises(RuntimeError, match="no clone"):
                await asyncio.to_thread(robot.call, "/fail", GET_MAP, {})
            with pytest.raises(RuntimeError, match=r"not nav_msgs/GetMap with 6cdd.*build the node"):
                await asyncio.to_thread(robot.call, "/static_map", GET_MAP, {}, "1234")
            assert await asyncio.to_thread(persistent, master, 3) == [3, 3, 3]


def persistent(master: MasterStandIn, count: int) -> list[int]:
    """Call ``/static_map`` several times on one connection; return the widths."""
    host, _, port = master.service_uris["/static_map"].removeprefix("rosrpc://").partition(":")
    with socket.create_connection((host, int(port)), timeout=20.0) as one:
        stream = one.makefile("rb")
        one.sendall(pack({"callerid": "/a", "service": "/static_map", "md5sum": "*", "persistent": "1"}))
        assert unpack(frame(stream))["type"] == "nav_msgs/GetMap"
        widths = []
        for _ in range(count):
            one.sendall(struct.pack("<I", 0))
            assert stream.read(1) == b"\1"
            widths.append(TYPES.decode(f"{GET_MAP}_Response", frame(stream))["map"]["info"]["width"])
    return widths


async def test_a_service_that_another_node_serves_is_left_to_it(
    master: MasterStandIn, caplog: pytest.LogCaptureFixture
) -> None:
    with node(master, "/map_server") as robot:
        robot.master.registerService("/map_server", "/static_map", "rosrpc://127.0.0.1:9", robot.uri)
        async with opened(master) as transport:
            transport.serve("/static_map", GET_MAP, lambda _: asyncio.sleep(0, b""))
            await until(lambda: "/static_map is served by /map_server, and so not by the cloud" in caplog.text)
            assert list(master.services["/static_map"]) == ["/map_server"]


async def test_another_type_is_told_on_both_sides(master: MasterStandIn, caplog: pytest.LogCaptureFixture) -> None:
    async with opened(master) as transport:
        transport.publisher("/map", GRID, LATCHED)
        transport.subscribe("/odom", STRING, Qos(), lambda _: None)
        await until(lambda: "/bridge" in master.publishers["/map"])
        with node(master) as robot:
            robot.publisher("/odom", "std_msgs/String", md5="0123")
            await until(lambda: "/odom is not received: the node refused: Client wants /odom to have" in caplog.text)
            assert "the node refused" in transport.faults()["/odom"]
            _, head = await asyncio.to_thread(robot.connect, "/map", "nav_msgs/GridCells", master.nodes["/bridge"])
            assert "not nav_msgs/OccupancyGrid with 3381f2d731d4076ec5c71b0759edbe4e" in head["error"]
            assert "/robot does not get /map" in caplog.text


async def test_a_subscriber_that_never_reads_delays_nobody_and_misses_the_oldest(
    master: MasterStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "WRITE_BUFFER", 1 << 12)
    async with opened(master) as transport:
        published = transport.publisher("/plan", STRING, Qos(depth=3))
        await until(lambda: "/bridge" in master.publishers["/plan"])
        read: list[int] = []
        with node(master, "/lazy") as lazy, node(master, "/eager") as eager:
            held, _ = await asyncio.to_thread(lazy.connect, "/plan", "std_msgs/String", master.nodes["/bridge"])
            eager.subscribe("/plan", "std_msgs/String", lambda message: read.append(int(message["data"][:5])))
            await until(lambda: len(transport.publications["/plan"].peers) == 2)
            for number in range(200):
                published.publish(text(f"{number:05d}" + "." * 100_000))
                await until(lambda number=number: len(read) == number + 1)
            [peer] = [one for one in transport.publications["/plan"].peers if one.node == "/lazy"]
            assert len(peer._queue) == 3
            stream, numbers = held.makefile("rb"), [-1]
            while numbers[-1] < 199:
                numbers.append(int(TYPES.decode(STRING, await asyncio.to_thread(frame, stream))["data"][:5]))
            assert len(numbers) < 200, "the oldest were dropped"
            assert numbers == sorted(numbers)
            assert numbers[-3:] == [197, 198, 199]


async def test_stalled_subscribers_connect_anew_once_the_network_is_back(
    master: MasterStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []
    async with opened(master) as transport:
        published = transport.publisher("/cmd_vel", STRING, Qos(depth=1))
        with node(master) as robot:
            robot.subscribe("/cmd_vel", "std_msgs/String", lambda message: read.append(message["data"]))
            await until(lambda: transport.publications["/cmd_vel"].peers)
            [before] = transport.publications["/cmd_vel"].peers
            assert not before.stalled
            monkeypatch.setattr(NodeConnection, "stalled", property(lambda peer: peer is before))
            transport._revive()
            await until(lambda: [one for one in transport.publications["/cmd_vel"].peers if one is not before])
            published.publish(text("go"))
            await until(lambda: read == ["go"])


async def test_a_second_bridge_of_the_same_name_ends_the_first(master: MasterStandIn) -> None:
    async with opened(master) as first:
        first.publisher("/a", STRING, Qos())
        await until(lambda: "/bridge" in master.publishers["/a"])
        async with opened(master) as second:
            second.publisher("/a", STRING, Qos())
            with pytest.raises(
                Conflict, match=r"new node registered with same name /bridge; is there a second bridge\?"
            ):
                await asyncio.wait_for(first.ended(), 30)


async def test_what_other_nodes_ask_is_answered(master: MasterStandIn) -> None:
    async with opened(master) as transport:
        transport.publisher("/a", STRING, Qos())
        await until(lambda: "/bridge" in master.publishers["/a"])
        with node(master) as robot:
            robot.subscribe("/a", "std_msgs/String", lambda _: None)
            await until(lambda: transport.publications["/a"].peers)
            asked = xmlrpc.client.ServerProxy(master.nodes["/bridge"])

            def ask(method: str, *arguments: Any) -> Any:
                return getattr(asked, method)("/robot", *arguments)

            info = await asyncio.to_thread(ask, "getBusInfo")
            assert info == [1, "connections", [[1, "/robot", "o", "TCPROS", "/a", True]]]
            assert (await asyncio.to_thread(ask, "getPublications"))[2] == [["/a", "std_msgs/String"]]
            assert (await asyncio.to_thread(ask, "getBusStats"))[2][0][0][:1] == ["/a"]
            assert (await asyncio.to_thread(ask, "getMasterUri"))[2] == master.uri
            assert (await asyncio.to_thread(ask, "getPid"))[2] > 1
            assert (await asyncio.to_thread(ask, "requestTopic", "/b", [["TCPROS"]]))[0] == 0
            assert (await asyncio.to_thread(ask, "requestTopic", "/a", [["UDPROS"]]))[0] == 0
            assert (await asyncio.to_thread(ask, "requestTopic"))[:1] == [-1]
            assert "unknown method" in (await asyncio.to_thread(ask, "dance"))[1]


@pytest.mark.parametrize(
    "data",
    [b"\xff\xff\xff\xff", b"\3\0\0\0abc", b"GET / HTTP/1.1\r\n\r\n", pack({"callerid": "/a", "topic": "/no"}), b""],
)
async def test_strangers_on_the_data_port_end_nothing(
    data: bytes, master: MasterStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "HEADER_TIMEOUT", 0.1)
    async with opened(master) as transport:

        def send() -> bytes:
            with socket.create_connection(transport.data_address(), timeout=20.0) as one:
                one.sendall(data)
                return one.recv(100)

        answer = await asyncio.to_thread(send)
        assert b"error=" in answer if b"callerid" in data or b"abc" in data else answer == b""
        await until(lambda: not transport._peers)


async def test_strangers_on_the_port_of_calls_end_nothing(master: MasterStandIn) -> None:
    async with opened(master) as transport:
        transport.publisher("/a", STRING, Qos())
        await until(lambda: "/bridge" in master.nodes)
        port = int(master.nodes["/bridge"].rstrip("/").rpartition(":")[2])

        def send(data: bytes) -> bytes:
            # The connection is closed as soon as too much has arrived.
            with socket.create_connection(("127.0.0.1", port), timeout=20.0) as one, suppress(ConnectionError):
                one.sendall(data)
                one.shutdown(socket.SHUT_WR)
                return one.makefile("rb").read()
            return b""

        assert await asyncio.to_thread(send, b"\0\1\2\r\n\r\n") == b""
        head = b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: "
        assert b"faultString" in await asyncio.to_thread(send, head + b"3\r\n\r\nabc")
        assert await asyncio.to_thread(send, head + b"9000000\r\n\r\n" + b"a" * 9_000_000) == b""
        transport.publisher("/b", STRING, Qos())
        await until(lambda: "/bridge" in master.publishers["/b"])


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (["UDPROS", "127.0.0.1", 1], "offers no TCPROS"),
        (["TCPROS", "127.0.0.1", 70000], "a port that cannot be: 70000"),
        (["TCPROS", "a" * 80 + ".b", 7], "set ROS_IP of the robot"),
        (["TCPROS", "127.0.0.1", 1], "set ROS_IP of the robot"),
        (7, "offers no TCPROS"),
    ],
)
async def test_publishers_that_lie_about_themselves_are_told_of(
    answer: Any, text: str, master: MasterStandIn, caplog: pytest.LogCaptureFixture
) -> None:
    async with opened(master) as transport:
        transport.subscribe("/odom", STRING, Qos(), lambda _: None)
        with node(master) as robot:
            robot._server.register_function(lambda *_: [1, "ready", answer], "requestTopic")
            robot.publisher("/odom", "std_msgs/String")
            await until(lambda: text in caplog.text)


async def test_what_cannot_be_opened_is_explained() -> None:
    for uri in ("localhost:11311", "http://localhost", "rosrpc://a:1", "http://a:x"):
        with pytest.raises(InvalidInput, match="write http://HOST:PORT"):
            Ros1Transport(Ros1Options(uri))
    with pytest.raises(InvalidInput, match="cannot be reached"):
        await Ros1Transport(Ros1Options("http://no.such.host.invalid:11311")).open(lambda: None)


def test_each_robot_has_a_node_of_its_own() -> None:
    assert node_name("tb3 1/ü") == "ppaas_bridge_tb3_1__"

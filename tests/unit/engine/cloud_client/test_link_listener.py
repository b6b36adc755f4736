"""Containers and strangers dial the listener of an endpoint."""

import asyncio
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from engine.cloud_client.link_listener import LinkListener, MachineAccess
from engine.cloud_client.sessions import EndpointPlaces
from engine.protocols import handshakes, robot_link
from engine.protocols.address import TlsAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import place_secret
from engine.protocols.refusals import Refusal
from engine.protocols.sockets import dial_pinned
from engine.protocols.tls_identity import stranger_context
from engine.protocols.versions import Protocols
from engine.remote.authority import Authority
from engine.remote.membership import enrol
from ppaas.errors import NotPermitted
from tests.support.engine.engine_links import dial_link, hello, receive
from tests.support.waiting import patience, until

PLACE = "robot:ann/tb1"
OTHER = "robot:bob/tb2"


@pytest.fixture
def places() -> EndpointPlaces:
    return EndpointPlaces()


@pytest.fixture
async def listener(tmp_path: Path, places: EndpointPlaces) -> AsyncIterator[LinkListener]:
    made = LinkListener("hall", tmp_path / "link.sock", places.link)
    await made.start()
    yield made
    await made.close()


def hello_of(
    listener: LinkListener, place: str = PLACE, container: str = "c1", generation: int = 1
) -> robot_link.Hello:
    """Return the first frame of a container of a place."""
    secret = place_secret(listener.secret, place, generation)
    return replace(hello(container, secret), place=place, generation=generation)


Stream = FrameStream[robot_link.ToContainer]


async def dial(listener: LinkListener, first: robot_link.FromContainer) -> Stream:
    stream = await dial_link(listener.path)
    stream.write(first)
    return stream


async def check_served(places: EndpointPlaces, stream: Stream, place: str = PLACE) -> None:
    """Check that a call at a place reaches the container at a stream, and that its answer comes back."""
    asking = asyncio.create_task(places.link(place).call("make_plan", b"{}", 10.0))
    call = await receive(stream)
    assert isinstance(call, robot_link.ServiceCall) and call.service == "make_plan"
    stream.write(robot_link.ServiceAnswer(call.call, b'{"of":"this container"}'))
    assert await asking == b'{"of":"this container"}'


async def test_socket_is_accessible_to_its_user_only(listener: LinkListener) -> None:
    assert stat.S_IMODE(listener.path.stat().st_mode) == 0o600


async def test_containers_are_served_by_the_links_of_their_places(
    listener: LinkListener, places: EndpointPlaces
) -> None:
    streams = {}
    for place, container in ((PLACE, "c1"), (OTHER, "c2")):
        streams[place] = await dial(listener, hello_of(listener, place, container))
        await places.link(place).ready(10.0)
        assert places.link(place).container == container
    for place, stream in streams.items():
        await check_served(places, stream, place)
        await stream.close()


def refused_first_frames(listener: LinkListener) -> dict[str, robot_link.FromContainer]:
    right = hello_of(listener)
    return {
        "wrong secret": replace(right, secret="wrong"),
        "no secret": replace(right, secret=""),
        "odd secret": replace(right, secret="schlüssel"),
        "secret of the endpoint": replace(right, secret=listener.secret),
        "secret of another place": replace(right, secret=hello_of(listener, OTHER).secret),
        "no place": replace(right, place=""),
        "later generation": replace(right, generation=2),
        "failed": robot_link.ContainerFailed("c1", right.secret, Refusal("not-found", "")),
        "no hello": robot_link.Ack(1),
    }


@pytest.mark.parametrize(
    "kind",
    [
        "wrong secret", "no secret", "odd secret", "secret of the endpoint", "secret of another place", "no place",
        "later generation", "failed", "no hello",
    ],
)  # fmt: skip
async def test_a_stranger_is_refused_and_nobody_else_notices(
    listener: LinkListener, places: EndpointPlaces, kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    served = await dial(listener, hello_of(listener))
    await places.link(PLACE).ready(10.0)
    stranger = await dial(listener, refused_first_frames(listener)[kind])
    assert await receive(stranger) is None
    assert "without the secret of its place" in caplog.text
    assert places.link(PLACE).container == "c1"
    await check_served(places, served)
    await stranger.close()
    await served.close()


async def test_a_silent_client_is_closed_and_nobody_else_notices(
    listener: LinkListener,
    places: EndpointPlaces,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    served = await dial(listener, hello_of(listener))
    await places.link(PLACE).ready(10.0)
    monkeypatch.setattr("engine.cloud_client.link_listener.HELLO_TIMEOUT", 0.05)
    silent = await dial_link(listener.path)
    assert await receive(silent) is None
    assert "sent no first frame in time" in caplog.text
    await check_served(places, served)
    await silent.close()
    await served.close()


async def test_many_silent_clients_make_room_for_a_container(
    listener: LinkListener, places: EndpointPlaces, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(handshakes, "MOST", 20)
    monkeypatch.setattr("engine.cloud_client.link_listener.HELLO_TIMEOUT", 60.0)
    served = await dial(listener, hello_of(listener, OTHER, "c2"))
    await places.link(OTHER).ready(10.0)
    silent = [await dial_link(listener.path) for _ in range(100)]
    late = await dial(listener, hello_of(listener))
    await places.link(PLACE).ready(10.0)
    for stream in silent[:80]:
        assert await receive(stream) is None
    assert caplog.text.count("say nothing") == 1
    await check_served(places, late)
    await check_served(places, served, OTHER)
    for stream in (served, late, *silent):
        await stream.close()


async def test_invalid_bytes_are_refused(listener: LinkListener, caplog: pytest.LogCaptureFixture) -> None:
    reader, writer = await asyncio.open_unix_connection(listener.path)
    writer.write(b"GET / HTTP/1.1\r\n\r\n")
    async with patience(10.0):
        assert await reader.read() == b""
    assert "closed a link of a container" in caplog.text
    writer.close()


async def test_the_next_container_of_a_place_replaces_the_one_before(
    listener: LinkListener, places: EndpointPlaces
) -> None:
    first = await dial(listener, hello_of(listener))
    await places.link(PLACE).ready(10.0)
    await first.close()
    second = await dial(listener, hello_of(listener, container="c2", generation=2))
    await until(lambda: places.link(PLACE).container == "c2")
    await check_served(places, second)
    await second.close()


async def test_a_container_that_speaks_no_protocol_of_the_endpoint_is_shut_down(
    listener: LinkListener, places: EndpointPlaces, caplog: pytest.LogCaptureFixture
) -> None:
    stream = await dial(listener, replace(hello_of(listener), protocols=Protocols(8, 9)))
    assert await receive(stream) == robot_link.Shutdown()
    assert await receive(stream) is None
    assert "with protocols 8 to 9" in caplog.text and places.link(PLACE).container is None
    await stream.close()


async def test_a_container_that_was_replaced_is_shut_down_and_its_successor_does_not_notice(
    listener: LinkListener, places: EndpointPlaces
) -> None:
    second = await dial(listener, hello_of(listener, container="c2", generation=2))
    await places.link(PLACE).ready(10.0)
    first = await dial(listener, hello_of(listener, container="c1", generation=1))
    assert await receive(first) == robot_link.Shutdown()
    assert await receive(first) is None
    assert places.link(PLACE).container == "c2"
    await check_served(places, second)
    again = await dial(listener, replace(hello_of(listener, container="c2", generation=2), pid=43))
    await until(lambda: places.link(PLACE).pid == 43)
    await check_served(places, again)
    for stream in (first, second, again):
        await stream.close()


async def test_links_end_with_the_listener(tmp_path: Path, places: EndpointPlaces) -> None:
    listener = LinkListener("hall", tmp_path / "other.sock", places.link)
    await listener.start()
    stream = await dial(listener, hello_of(listener))
    await places.link(PLACE).ready(10.0)
    await listener.close()
    assert await receive(stream) is None
    assert not listener.path.exists()
    await stream.close()


async def test_a_container_of_another_host_dials_the_certificate_that_its_order_names(
    tmp_path: Path, places: EndpointPlaces
) -> None:
    """Its machine has a certificate of the cloud; a server with another certificate gets nothing."""
    authority = Authority(tmp_path / "cloud")
    hall = enrol(tmp_path / "hall", authority, "hall", TlsAddress("127.0.0.1", 1)).identity
    listener = LinkListener("local", tmp_path / "far.sock", places.link, MachineAccess("127.0.0.1", hall.authority))
    await listener.start()
    address = parse_address(listener.address.far)
    assert isinstance(address, TlsAddress) and listener.address.machine == "local"
    with pytest.raises(NotPermitted, match="another one than expected"):
        await dial_pinned(address, hall.pinning_context("robot"), "0" * 64)
    stream: Stream = FrameStream(
        *await dial_pinned(address, hall.pinning_context("robot"), listener.address.fingerprint),
        robot_link.ToContainer,
    )
    stream.write(hello_of(listener))
    await places.link(PLACE).ready(10.0)
    await check_served(places, stream)
    stranger = stranger_context()
    stranger.set_alpn_protocols(["robot"])
    refused: Stream = FrameStream(
        *await dial_pinned(address, stranger, listener.address.fingerprint), robot_link.ToContainer
    )
    refused.write(hello_of(listener, container="c2", generation=2))
    assert await receive(refused) is None, "a container whose machine has no certificate"
    for each in (stream, refused):
        await each.close()
    await listener.close()
    assert not listener.path.exists() and not listener.path.with_suffix(".key").exists()

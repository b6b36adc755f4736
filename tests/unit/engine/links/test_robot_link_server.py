"""Tests of the robot link server, with expected containers and strangers."""

import asyncio
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.links.robot_link_server import LinkServer
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from ppaas.errors import NotFound, rebuild
from tests.support.engine.engine_links import connection, dial_link, hello, receive
from tests.support.waiting import until


class Welcomes:
    """Greets each container with a frame, and serves it until it disconnects."""

    def __init__(self) -> None:
        self.hellos: list[robot_link.Hello] = []
        self.heard: list[robot_link.FromContainer] = []
        self.failures: list[robot_link.ContainerFailed] = []

    async def welcome(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        self.hellos.append(hello)
        stream.write(robot_link.SubscribeTopic("welcome", 0))
        while (frame := await stream.receive()) is not None:
            self.heard.append(frame)


@pytest.fixture
def welcomes() -> Welcomes:
    return Welcomes()


@pytest.fixture
async def server(tmp_path: Path, welcomes: Welcomes) -> AsyncIterator[LinkServer]:
    opened = LinkServer(tmp_path / "link.sock", welcomes.welcome, welcomes.failures.append, hello_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


async def test_socket_is_accessible_to_its_user_only(server: LinkServer) -> None:
    assert stat.S_IMODE(server.path.stat().st_mode) == 0o600


async def test_expected_container_is_welcomed_and_served(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    stream = await dial_link(server.path)
    stream.write(hello("c1", "s1"))
    assert await receive(stream) == robot_link.SubscribeTopic("welcome", 0)
    stream.write(robot_link.Ack(7))
    await stream.close()
    await until(lambda: welcomes.heard)
    assert welcomes.heard == [robot_link.Ack(7)]
    assert server.awaited == 0


@pytest.mark.parametrize(
    "first",
    [
        hello("c1", "wrong"),
        hello("c1", ""),
        hello("c1", "schlüssel"),
        hello("c2", "s1"),
        robot_link.ContainerFailed("c1", "wrong", Refusal("not-found", "")),
        robot_link.Ack(1),
    ],
    ids=["wrong secret", "no secret", "odd secret", "unknown container", "failed with wrong secret", "no hello"],
)
async def test_unknown_client_is_disconnected_and_the_expected_one_connects(
    server: LinkServer, welcomes: Welcomes, first: robot_link.FromContainer, caplog: pytest.LogCaptureFixture
) -> None:
    server.expect("c1", "s1")
    stranger = await dial_link(server.path)
    stranger.write(first)
    assert await receive(stranger) is None
    assert not welcomes.hellos and not welcomes.failures
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    stream = await dial_link(server.path)
    stream.write(hello("c1", "s1"))
    assert await receive(stream) == robot_link.SubscribeTopic("welcome", 0)
    await stream.close()


async def test_link_is_opened_only_once(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    first = await dial_link(server.path)
    first.write(hello("c1", "s1"))
    assert await receive(first) == robot_link.SubscribeTopic("welcome", 0)
    second = await dial_link(server.path)
    second.write(hello("c1", "s1"))
    assert await receive(second) is None
    assert len(welcomes.hellos) == 1
    await first.close()


async def test_forgotten_container_cannot_connect(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    server.forget("c1")
    stream = await dial_link(server.path)
    stream.write(hello("c1", "s1"))
    assert await receive(stream) is None
    assert welcomes.hellos == []


async def test_silent_client_is_disconnected(
    tmp_path: Path, welcomes: Welcomes, caplog: pytest.LogCaptureFixture
) -> None:
    server = LinkServer(tmp_path / "link.sock", welcomes.welcome, welcomes.failures.append, hello_timeout=0.05)
    await server.start()
    stream = await dial_link(server.path)
    assert await receive(stream) is None
    await server.close()
    assert "the container sent no first frame in time" in caplog.text


async def test_client_that_sends_invalid_bytes_is_disconnected(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    reader, writer = await asyncio.open_unix_connection(server.path)
    writer.write(b"GET / HTTP/1.1\r\n\r\n")
    assert await reader.read() == b""
    writer.close()
    stream = await dial_link(server.path)
    stream.write(hello("c1", "s1"))
    assert await receive(stream) == robot_link.SubscribeTopic("welcome", 0)
    await stream.close()


async def test_container_failure_is_reported_with_its_reason(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    stream = await dial_link(server.path)
    error = NotFound("model", "toaster", ["turtlebot2"])
    stream.write(robot_link.ContainerFailed("c1", "s1", Refusal(error.slug, str(error))))
    assert await receive(stream) is None
    (failed,) = welcomes.failures
    rebuilt = rebuild(failed.refusal.slug, failed.refusal.text)
    assert isinstance(rebuilt, NotFound)
    assert str(rebuilt) == "unknown model 'toaster'; known: turtlebot2"
    assert server.awaited == 0


async def test_closing_disconnects_all_and_removes_the_socket(server: LinkServer) -> None:
    server.expect("c1", "s1")
    known, silent = await dial_link(server.path), await dial_link(server.path)
    known.write(hello("c1", "s1"))
    assert await receive(known) == robot_link.SubscribeTopic("welcome", 0)
    await server.close()
    assert await receive(known) is None
    assert await receive(silent) is None
    assert not server.path.exists()
    with pytest.raises(OSError):
        await dial_link(server.path)


@pytest.mark.parametrize("machine", ["m2", "m3"], ids=["its own", "another"])
async def test_remote_container_connects_only_through_its_own_machine(
    server: LinkServer, welcomes: Welcomes, machine: str
) -> None:
    server.expect("c1", "s1", "m2")
    stream, reader, writer = await connection(robot_link.ToContainer)
    serving = asyncio.create_task(server.connected(reader, writer, machine))
    await stream.send(hello("c1", "s1"))
    await until(lambda: welcomes.hellos or serving.done())
    assert len(welcomes.hellos) == (1 if machine == "m2" else 0)
    await stream.close()
    await serving


async def test_disconnected_container_receives_no_more_frames(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    stream = await dial_link(server.path)
    stream.write(hello("c1", "s1"))
    await until(lambda: welcomes.hellos)
    server.hang_up("c1")
    server.hang_up("nobody")
    assert await receive(stream) == robot_link.SubscribeTopic("welcome", 0)
    assert await receive(stream) is None


async def test_a_container_may_wait_for_kernels_before_its_hello(tmp_path: Path, welcomes: Welcomes) -> None:
    waiting: list[str] = []
    opened = LinkServer(tmp_path / "l.sock", welcomes.welcome, welcomes.failures.append, waits=waiting.append)
    await opened.start()
    opened.expect("c1", "s1")
    stream = await dial_link(opened.path)
    for _ in range(2):
        stream.write(robot_link.KernelsAwaited("c1", "s1"))
    await until(lambda: waiting == ["c1", "c1"])
    stream.write(hello("c1", "s1"))
    assert await receive(stream) == robot_link.SubscribeTopic("welcome", 0)
    await stream.close()
    await opened.close()


async def test_a_stranger_does_not_wait_for_kernels(server: LinkServer, welcomes: Welcomes) -> None:
    server.expect("c1", "s1")
    stream = await dial_link(server.path)
    stream.write(robot_link.KernelsAwaited("c1", "wrong"))
    assert await receive(stream) is None
    assert server.awaited == 1

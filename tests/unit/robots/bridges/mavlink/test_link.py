"""Lines to vehicles: TCP and serial ones are opened again when they are lost."""

import asyncio
import os
import pty
import tty
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from robots.bridges.mavlink import link
from robots.bridges.mavlink.link import LINES, VehicleAddress, VehicleLine
from tests.support.waiting import until


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "RETRY", 0.02)


@asynccontextmanager
async def opened(text: str, received: Callable[[bytes], None]) -> AsyncIterator[VehicleLine]:
    address = VehicleAddress.parse(text)
    line = LINES[address.kind](address, lambda data, _: received(data))
    task = asyncio.create_task(line.run())
    try:
        yield line
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def is_open(line: VehicleLine) -> bool:
    """Return whether a serial line has its device."""
    return line._port is not None  # type: ignore[attr-defined]


async def test_a_vehicle_that_closes_its_tcp_connection_is_called_again() -> None:
    heard: list[bytes] = []
    calls = 0

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal calls
        calls += 1
        writer.write(b"%d" % calls)
        if calls > 1:
            heard.append(b"answered " + await reader.read(100))
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    got: list[bytes] = []
    async with opened(f"tcp:127.0.0.1:{port}", got.append) as line:
        line.send(b"too early", None)
        await until(lambda: b"2" in b"".join(got), 10.0)
        line.send(b"hello", None)
        await until(lambda: heard == [b"answered hello"], 10.0)
        server.close()
        await asyncio.sleep(0.1)  # it goes on trying


async def test_a_serial_line_that_was_pulled_out_is_opened_again(tmp_path: Path) -> None:
    device = tmp_path / "ttyVehicle"
    ends = pty.openpty()
    tty.setraw(ends[1])
    device.symlink_to(os.ttyname(ends[1]))
    got: list[bytes] = []
    async with opened(str(device), got.append) as line:
        await until(lambda: is_open(line), 10.0)
        os.write(ends[0], b"from the vehicle")
        await until(lambda: got == [b"from the vehicle"], 10.0)
        line.send(b"to it", None)
        assert os.read(ends[0], 100) == b"to it"
        device.unlink()
        for end in ends:
            os.close(end)
        await until(lambda: not is_open(line), 10.0)
        ends = pty.openpty()
        tty.setraw(ends[1])
        device.symlink_to(os.ttyname(ends[1]))
        await until(lambda: is_open(line), 10.0)
        os.write(ends[0], b"again")
        await until(lambda: got[-1] == b"again", 10.0)
    for end in ends:
        os.close(end)


async def test_a_port_that_is_in_use_is_named() -> None:
    loop = asyncio.get_running_loop()
    transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, local_addr=("127.0.0.1", 0))
    port = transport.get_extra_info("sockname")[1]
    try:
        address = VehicleAddress.parse(f"udpin:127.0.0.1:{port}")
        with pytest.raises(Unavailable, match=f"cannot open udpin:127.0.0.1:{port}"):
            await LINES["udpin"](address, lambda *_: None).run()
    finally:
        transport.close()

"""A machine without processes: the test controls its containers over real links."""

import asyncio
from pathlib import Path
from typing import Self

import msgspec

from engine.protocols import control_link, robot_link
from engine.protocols.framing import FrameStream
from ppaas import __version__
from tests.support.engine.engine_links import dial_control, dial_link, hello, receive, register
from tests.support.waiting import patience


class FarContainer:
    """The container's end of a robot link."""

    def __init__(self, order: control_link.StartContainer, stream: FrameStream[robot_link.ToContainer]) -> None:
        self.spec = order.spec
        self.stream = stream

    async def next(self) -> robot_link.ToContainer | None:
        """Return the next message of the endpoint, or None if it closed the connection."""
        frame: robot_link.ToContainer | None = await receive(self.stream)
        return frame


class FakeMachine:
    """An agent whose orders the test executes."""

    def __init__(self, stream: FrameStream[control_link.ToAgent]) -> None:
        self._stream = stream
        self.dismissed = False
        self.welcome: asyncio.Future[control_link.Welcome] = asyncio.get_running_loop().create_future()
        self._orders: asyncio.Queue[control_link.ToAgent | None] = asyncio.Queue()
        self._receiving = asyncio.create_task(self._receive())

    @classmethod
    async def join(
        cls,
        run_dir: Path,
        machine: str = "m1",
        secret: str = "secret",
        cores: int = 2,
        carries: tuple[control_link.RunningContainer, ...] = (),
        release: str = __version__,
    ) -> Self:
        """Register with the master."""
        stream = await dial_control(run_dir / "control.sock")
        stream.write(register(machine, secret, cores, carries, release))
        return cls(stream)

    async def _receive(self) -> None:
        while (order := await self._stream.receive()) is not None:
            if isinstance(order, control_link.Welcome):
                self.welcome.set_result(order)
            elif isinstance(order, control_link.Dismissed):
                self.dismissed = True
            else:
                self._orders.put_nowait(order)
        self._orders.put_nowait(None)

    async def order(self) -> control_link.ToAgent | None:
        """Return the next order, or None if the master closed the connection."""
        async with patience(10):
            return await self._orders.get()

    async def started(self) -> control_link.StartContainer:
        """Return the next order, which must be to start a container."""
        order = await self.order()
        assert isinstance(order, control_link.StartContainer), order
        return order

    async def stopped(self) -> str:
        """Return the container of the next order, which must be to stop it."""
        order = await self.order()
        assert isinstance(order, control_link.StopContainer), order
        return order.container

    def has_orders(self) -> bool:
        """Return whether there are unread orders."""
        return not self._orders.empty()

    def tell(self, event: msgspec.Struct) -> None:
        """Send a message to the master."""
        self._stream.write(event)

    async def boot(self, order: control_link.StartContainer, pid: int = 42, applied: int = 0) -> FarContainer:
        """Act as the process of the ordered container: report it, and dial the robot link."""
        self.tell(control_link.Launched(order.spec.id, pid))
        stream = await dial_link(order.link)
        stream.write(hello(order.spec.id, order.secret, pid, applied))
        return FarContainer(order, stream)

    async def kill(self, container: FarContainer, status: int = -9) -> None:
        """Report the exit of a container's process."""
        await container.stream.close()
        self.tell(control_link.Exited(container.spec.id, status))

    async def leave(self) -> None:
        """Close the control link."""
        await self._stream.close()
        await self._receiving

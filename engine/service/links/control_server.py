"""Where machines register: each agent tells what happens and takes orders.

The agent of this machine dials a Unix socket and shows a secret; machines of other hosts show their certificate.
"""

import asyncio
import logging
from pathlib import Path
from typing import Protocol

import msgspec

from engine.protocols import control_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.pending_handshakes import is_same
from engine.protocols.sockets import listen
from ppaas.errors import MalformedMessage, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

REGISTER_TIMEOUT = 5.0


class ControlEvents(Protocol):
    """Who is told."""

    async def machine_registered(self, register: control_link.Register) -> None:
        """A machine is here; orders may be sent to it."""
        ...

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Something happened on a machine."""
        ...

    def machine_gone(self, machine: str) -> None:
        """Its agent hung up: what it carried is lost."""
        ...


class ControlServer:
    """The master's end of the control links.

    Parameters
    ----------
    path : Path
        Of the socket; only this user may connect to it.
    secret : str
        Shows that an agent of this machine is ours.
    events : ControlEvents
        Who is told.
    register_timeout : float
        Seconds that whoever dials has to register.
    """

    def __init__(
        self, path: Path, secret: str, events: ControlEvents, *, register_timeout: float = REGISTER_TIMEOUT
    ) -> None:
        self.path = path
        self._secret = secret
        self._events = events
        self._register_timeout = register_timeout
        self._streams: set[FrameStream[control_link.FromAgent]] = set()
        self._machines: dict[str, FrameStream[control_link.FromAgent]] = {}
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Listen."""
        self._server = await listen(UnixAddress(self.path), self.connected)

    def order(self, machine: str, order: msgspec.Struct) -> None:
        """Send an order.

        Raises
        ------
        Unavailable
            The machine is gone.
        """
        stream = self._machines.get(machine)
        if stream is None:
            raise Unavailable(f"machine {machine!r} is gone")
        stream.write(order)

    def hang_up(self, machine: str) -> None:
        """Cut a machine off, which is then gone; it may come again with what it carries."""
        stream = self._machines.get(machine)
        if stream is not None:
            stream.abort()

    async def dismiss(self, machine: str) -> None:
        """Let a machine go, which ends all that it carries."""
        stream = self._machines.get(machine)
        if stream is not None:
            await _dismiss(stream)

    async def connected(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str | None = None
    ) -> None:
        """Serve a connection; ``machine`` is whom its certificate names, where it has come with one."""
        stream: FrameStream[control_link.FromAgent] = FrameStream(reader, writer, control_link.FromAgent)
        self._streams.add(stream)
        try:
            await self._serve(await self._registered(stream, machine), stream, answers=machine is not None)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("a machine was cut off: %s", error or "it said nothing")
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def _registered(
        self, stream: FrameStream[control_link.FromAgent], machine: str | None
    ) -> control_link.Register:
        try:
            async with asyncio.timeout(self._register_timeout):
                register = await stream.receive()
        except MalformedMessage:  # of another release, and it would dial again and again
            stream.write(control_link.Dismissed())
            raise
        if not isinstance(register, control_link.Register):
            raise NotPermitted("something dialled the control link that is no machine")
        if machine is None and not is_same(self._secret, register.secret):
            raise NotPermitted("something dialled the control link that is no machine of ours")
        if machine not in (None, register.machine):
            raise NotPermitted(f"machine {machine!r} calls itself {register.machine[:64]!r}")
        if register.machine in self._machines:
            raise NotPermitted(f"a second machine calls itself {register.machine!r}")
        return register

    async def _serve(
        self, register: control_link.Register, stream: FrameStream[control_link.FromAgent], *, answers: bool
    ) -> None:
        machine = register.machine
        self._machines[machine] = stream
        try:
            await self._events.machine_registered(register)
            while (event := await stream.receive()) is not None:
                self._events.machine_said(machine, event)
                if answers and isinstance(event, control_link.AgentBeat):
                    stream.write(control_link.BeatAcknowledged())
        except Unavailable:  # a store is away: the machine keeps what it carries, and tries again
            raise
        except PPaaSError:
            stream.write(control_link.Dismissed())
            raise
        finally:
            del self._machines[machine]
            self._events.machine_gone(machine)

    async def close(self) -> None:
        """Let all machines go, which makes their agents end, and listen no more."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(_dismiss(stream) for stream in self._streams))
        self.path.unlink(missing_ok=True)


async def _dismiss(stream: FrameStream[control_link.FromAgent]) -> None:
    stream.write(control_link.Dismissed())
    await stream.close()

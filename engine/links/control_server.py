"""Server of the control links: agents register here, report events and receive orders.

The local agent connects to a Unix socket and presents a secret. Machines of other hosts present a certificate.
"""

import asyncio
import logging
from pathlib import Path
from typing import Protocol

import msgspec

from engine.leadership.leadership import Mandate, SoleMaster
from engine.protocols import control_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import is_same
from engine.protocols.sockets import listen
from engine.specs.start_state import KernelProgress
from ppaas.errors import MalformedMessage, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

REGISTER_TIMEOUT = 5.0
"""Time within which a connected agent must register [s]."""


class ControlEvents(Protocol):
    """Receiver of the events of machines."""

    def machine_starting(self, machine: str, kernels: KernelProgress | None) -> None:
        """Handle the report of a machine that has not registered yet."""
        ...

    def machine_start_ended(self, machine: str) -> None:
        """Handle the end of these reports: the machine registers now, or has failed."""
        ...

    async def machine_registered(self, register: control_link.Register) -> None:
        """Handle a registration; from now on, orders may be sent to the machine."""
        ...

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Handle a report of a machine."""
        ...

    def machine_gone(self, machine: str) -> None:
        """Handle the end of a machine's link; its containers are lost."""
        ...


class ControlServer:
    """The master's end of the control links.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only this user may connect to it.
    secret : str
        Secret that the local agent presents.
    events : ControlEvents
        Receiver of the events.
    register_timeout : float
        Time within which a connected agent must register [s].

    Attributes
    ----------
    mandate : Mandate
        Right to give orders. Orders that are given without it wait until ``resume``.
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
        self._held: list[tuple[FrameStream[control_link.FromAgent], msgspec.Struct]] = []
        self.mandate: Mandate = SoleMaster()

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self.connected)

    def is_connected(self, machine: str) -> bool:
        """Return whether a machine has registered and is connected."""
        return machine in self._machines

    def order(self, machine: str, order: msgspec.Struct) -> None:
        """Send an order to a machine, now or once this master leads again.

        Raises
        ------
        Unavailable
            The machine is not connected.
        """
        stream = self._machines.get(machine)
        if stream is None:
            raise Unavailable(f"machine {machine!r} is not connected")
        self._held.append((stream, order))
        self.resume()

    def tell_all(self, order: msgspec.Struct) -> None:
        """Send an order to all machines."""
        for machine in tuple(self._machines):
            self.order(machine, order)

    def resume(self) -> None:
        """Send the orders that wait, if this master leads; those to machines that have left are dropped."""
        if not self.mandate.leads():
            return
        held, self._held = self._held, []
        for stream, order in held:
            stream.write(order)

    def hang_up(self, machine: str) -> None:
        """Close the link of a machine; it may reconnect with its containers."""
        stream = self._machines.get(machine)
        if stream is not None:
            stream.abort()

    async def dismiss(self, machine: str) -> None:
        """Dismiss a machine; its agent ends all its containers."""
        stream = self._machines.get(machine)
        if stream is not None:
            await self._dismiss(stream)

    async def connected(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str | None = None
    ) -> None:
        """Serve a connection; ``machine`` is the name in its certificate, None on the local socket."""
        stream: FrameStream[control_link.FromAgent] = FrameStream(reader, writer, control_link.FromAgent)
        self._streams.add(stream)
        try:
            first = await self._first(stream, machine)
            if isinstance(first, control_link.MachineStarting):
                await self._follow_start(first, stream)
            else:
                await self._serve(first, stream)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("closed a control link: %s", str(error) or "the machine did not register in time")
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def _first(
        self, stream: FrameStream[control_link.FromAgent], machine: str | None
    ) -> control_link.Register | control_link.MachineStarting:
        try:
            async with asyncio.timeout(self._register_timeout):
                first = await stream.receive()
        except MalformedMessage:  # an agent of another release would reconnect again and again
            self._write_dismissal(stream)
            raise
        if not isinstance(first, control_link.Register | control_link.MachineStarting):
            raise NotPermitted("the first frame on the control link is not a registration")
        if machine is None and not is_same(self._secret, first.secret):
            raise NotPermitted("a machine registered on the control link with a wrong secret")
        if machine not in (None, first.machine):
            raise NotPermitted(
                f"machine {machine!r} may not register as {first.machine[:64]!r}: its certificate names {machine!r}"
            )
        if isinstance(first, control_link.Register):
            self._check_registration(first)
        return first

    def _check_registration(self, register: control_link.Register) -> None:
        if register.machine in self._machines:
            raise NotPermitted(
                f"machine {register.machine!r} is already registered: choose another name for the second one"
            )
        self._check_epoch(register.machine, register.epoch)

    async def _follow_start(
        self, first: control_link.MachineStarting, stream: FrameStream[control_link.FromAgent]
    ) -> None:
        machine = first.machine
        try:
            self._events.machine_starting(machine, first.kernels)
            while isinstance(frame := await stream.receive(), control_link.MachineStarting):
                self._events.machine_starting(machine, frame.kernels)
            if frame is None:
                return
            raise NotPermitted(f"machine {machine!r} must register on another connection than that of its start")
        finally:
            self._events.machine_start_ended(machine)

    def _check_epoch(self, machine: str, epoch: int) -> None:
        self.mandate.heard_of(epoch)
        if epoch > self.mandate.epoch:
            raise Unavailable(
                f"machine {machine!r} follows a master of epoch {epoch}, and this one is of epoch {self.mandate.epoch}"
            )

    async def _serve(self, register: control_link.Register, stream: FrameStream[control_link.FromAgent]) -> None:
        machine = register.machine
        self._machines[machine] = stream
        try:
            await self._events.machine_registered(register)
            while (event := await stream.receive()) is not None:
                if isinstance(event, control_link.Outranked):
                    self._check_epoch(machine, event.epoch)
                    continue
                self._events.machine_said(machine, event)
                if isinstance(event, control_link.AgentBeat):
                    stream.write(control_link.BeatAcknowledged(self.mandate.leads()))
        except Unavailable:  # a store is unreachable: the machine keeps its containers and reconnects
            raise
        except PPaaSError:
            self._write_dismissal(stream)
            raise
        finally:
            del self._machines[machine]
            self._events.machine_gone(machine)

    async def close(self) -> None:
        """Stop listening, and dismiss all machines; their agents end. Without a mandate, only disconnect them."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(self._dismiss(stream) for stream in self._streams))
        self.path.unlink(missing_ok=True)

    async def _dismiss(self, stream: FrameStream[control_link.FromAgent]) -> None:
        self._write_dismissal(stream)
        await stream.close()

    def _write_dismissal(self, stream: FrameStream[control_link.FromAgent]) -> None:
        if self.mandate.leads():
            stream.write(control_link.Dismissed())

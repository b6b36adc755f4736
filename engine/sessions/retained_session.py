"""Retained session: a client's session with what outlives its sockets and its container."""

import asyncio

import msgspec

from engine.protocols.refusals import refusal_of
from engine.protocols.session_frames import (
    Attach,
    CountPlan,
    NumberedFrame,
    SessionClient,
    SessionOptions,
    SessionOver,
    Settled,
)
from engine.rights.access import Access
from engine.sessions.held_frames import HeldFrames
from engine.sessions.namespaces import scope_of
from engine.sessions.place.place import Place
from engine.sessions.plan_permits import PlanPermits
from engine.sessions.posting import Replay
from engine.sessions.session import ClientSession
from engine.sessions.socket_sink import SocketSink
from engine.sessions.unsettled import UnsettledFrames
from ppaas.errors import PPaaSError
from ppaas.wire.binary.packing import Packer
from ppaas.wire.ros.serialization import serialize
from ppaas.wire.rosbridge import RosbridgeSession

REPORT_PERIOD = 0.1
"""Longest time until a settled frame is reported to the endpoint that keeps it [s]."""


class SessionRecord(msgspec.Struct, frozen=True):
    """Session in a checkpoint: the frames that set it up, or that are not answered.

    ``taken`` is the number of the last frame of the client that was executed before the checkpoint, ``sent`` the number
    of frames that the client was sent.
    """

    id: str
    client: SessionClient
    options: SessionOptions
    access: Access
    taken: int
    frames: list[NumberedFrame]
    sent: int = 0


class RetainedSession:
    """Session that outlives its sockets.

    Parameters
    ----------
    place : Place
        Place of the robot.
    attach : Attach
        First request for it.

    Attributes
    ----------
    taken : int
        Number of the last frame of the client that was taken.
    sent_before : int
        Number of frames that the client was sent by earlier containers; those are not kept.
    sink : SocketSink, optional
        The current socket.
    """

    def __init__(self, place: Place, attach: Attach) -> None:
        self.id, self.client, self.options = attach.id, attach.client, attach.options
        self.taken = 0
        self.sent_before = attach.sent
        self.ended = False
        self.sink: SocketSink | None = None
        self.expiry: asyncio.TimerHandle | None = None
        self._permits = PlanPermits()
        self._reporting: asyncio.TimerHandle | None = None
        self.unsettled = UnsettledFrames(self._report_later)
        options = attach.options
        packer = Packer(compact=options.compact, png=options.png, serialize=serialize)
        wire = RosbridgeSession(options.level, scope_of(attach.client.robot, options.namespace), packer)
        self.session = ClientSession(
            place, attach.client.role, wire, attach.client.title, self._permits.take,
            access=attach.access, identity=f"goal-{self.id}", unsettled=self.unsettled, ask=self.ask_permit,
        )  # fmt: skip
        self.session.outbox.repeats = options.counts
        self.session.over.add_done_callback(lambda over: self._tell_over(over.result()))
        self._frames = HeldFrames(self.session.serve)

    def record(self) -> SessionRecord:
        """Return the session as a checkpoint has it."""
        waiting = [*self.session.waiting(), *self._frames.waiting()]
        executed = waiting[0].number - 1 if waiting else self.taken
        frames = {frame.number: frame for frame in (*self.unsettled.frames(), *waiting)}
        return SessionRecord(
            self.id, self.client, self.options, self.session.access, executed,
            [frames[number] for number in sorted(frames)], self.session.outbox.count,
        )  # fmt: skip

    # -- frames of the client ------------------------------------------------------------------------------------------

    def take(self, frame: NumberedFrame) -> None:
        """Execute a frame, unless it was taken before."""
        if frame.number > self.taken:
            self.taken = frame.number
            self._frames.take(frame)

    def replay(self, frame: NumberedFrame, replay: Replay) -> None:
        """Execute a frame that an earlier container got."""
        self.taken = max(self.taken, frame.number)
        self.session.serve(frame, replay)

    def release(self) -> None:
        """Execute the frames that wait for types of ROS."""
        self._frames.release()

    def continue_with(self, attach: Attach) -> list[int]:
        """Go on after the link to the endpoint was lost; return the frames that it keeps and that are settled."""
        self.session.outbox.resume(attach.sent)
        pending = {frame.number for frame in self.record().frames}
        taken = [frame.number for frame in attach.kept if frame.number <= self.taken]
        for frame in attach.kept:
            self.take(frame)
        return [number for number in taken if number not in pending]

    # -- permits -------------------------------------------------------------------------------------------------------

    def ask_permit(self) -> None:
        """Ask the endpoint whether the path that is requested is within the quota; a later one if there is none now."""
        if self.sink is not None:
            self.sink.link.write(CountPlan(self.sink.socket))

    def permit(self, refusal: PPaaSError | None) -> None:
        """Take the answer."""
        self._permits.answer(refusal)
        self.session.resume()

    # -- the socket ----------------------------------------------------------------------------------------------------

    def connect(self, sink: SocketSink | None) -> None:
        """Send through a socket from now on; with None, let all frames wait."""
        self.sink = sink
        self.session.outbox.connect(sink)
        if sink is not None and self.session.waiting():
            self.ask_permit()

    def _report_later(self) -> None:
        if self._reporting is None:
            self._reporting = asyncio.get_running_loop().call_later(REPORT_PERIOD, self._report)

    def _report(self) -> None:
        self._reporting = None
        settled = self.unsettled.take_settled()
        if settled and self.sink is not None:
            self.sink.link.write(Settled(self.sink.socket, settled))

    def _tell_over(self, reason: PPaaSError) -> None:
        if self.sink is not None:
            self.sink.link.write(SessionOver(self.sink.socket, refusal_of(reason)))

    def end(self) -> None:
        """End the session."""
        self.ended = True
        for timer in (self.expiry, self._reporting):
            if timer is not None:
                timer.cancel()
        self.connect(None)
        self.session.end()

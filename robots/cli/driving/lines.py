"""Driving by lines of JSON from another program, and the states of the robot as lines of JSON."""

import asyncio
import sys

import msgspec

from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.messages import encode
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopState
from robots.cli.driving.drive_loop import drive_by
from robots.cli.output import print_line
from robots.client.teleop import Hand

LONGEST = 1.0
"""Longest time for which one line drives [s]."""


class DriveLine(msgspec.Struct, forbid_unknown_fields=True):
    """A line by which a program drives.

    Parameters
    ----------
    linear, angular : float
        Velocity [m/s, rad/s].
    seconds : float
        Time for which it counts unless another line comes, at most `LONGEST` [s]; 0 lets go of the control.
    request : str
        ``give back`` to end driving, and have the robot go on to its goal; else empty.
    """

    linear: float = 0.0
    angular: float = 0.0
    seconds: float = 0.25
    request: str = ""


class Lines:
    """Lines of JSON of a program; a `MotionSource`. After the last one, driving ends once its time has passed."""

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self._velocity = 0.0, 0.0
        self._until = float("-inf")
        self._gives_back = self._is_closed = False
        self._invalid: InvalidInput | None = None

    def take(self, line: bytes) -> None:
        """Take a line; an empty one says that no more come. An invalid one ends driving with an error."""
        try:
            self._take(line)
        except InvalidInput as error:
            self._invalid = error
        self.changed.set()

    def _take(self, line: bytes) -> None:
        if not line:
            self._is_closed = True
            return
        try:
            read = from_json(line, DriveLine)
        except msgspec.DecodeError as error:
            raise InvalidInput(f"a line by which a program drives is not valid: {error}") from error
        if not 0.0 <= read.seconds <= LONGEST:
            raise InvalidInput(f"a line counts for 0 to {LONGEST:g} seconds, not {read.seconds:g}")
        if read.request not in ("", DriverRequest.GIVE_BACK):
            raise InvalidInput(f"the request of a line is 'give back' or empty, not {read.request[:32]!r}")
        self._velocity, self._until = (read.linear, read.angular), monotonic() + read.seconds
        self._gives_back = read.request == DriverRequest.GIVE_BACK

    def end(self, now: float) -> DriverRequest:
        """Return how driving ends, if it does; see `MotionSource.end`.

        Raises
        ------
        InvalidInput
            A line was not valid.
        """
        if self._invalid is not None:
            raise self._invalid
        if self._gives_back:
            return DriverRequest.GIVE_BACK
        return DriverRequest.LEAVE if self._is_closed and now >= self._until else DriverRequest.NOTHING

    def velocity(self, state: TeleopState, now: float) -> tuple[float, float] | None:
        """Return the wanted velocity; see `MotionSource.velocity`."""
        return self._velocity if now < self._until else None


async def drive_by_lines(hand: Hand) -> None:
    """Drive by the lines of the standard input; print the newest state of the robot after each command.

    Raises
    ------
    Conflict
        Another has taken over, or the turn has lapsed.
    InvalidInput
        A line is not valid, or the standard input is a file.
    """
    lines, loop = Lines(), asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    try:
        await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin.buffer)
    except ValueError as error:
        raise InvalidInput("lines by which a program drives come through a pipe, not from a file") from error
    reading = asyncio.create_task(_read(reader, lines))
    try:
        await drive_by(hand, lines, show_state)
    finally:
        reading.cancel()
        await asyncio.gather(reading, return_exceptions=True)


async def _read(reader: asyncio.StreamReader, lines: Lines) -> None:
    while line := await reader.readline():
        lines.take(line)
    lines.take(b"")


def show_state(hand: Hand) -> None:
    """Print the newest state of the robot, if there is one."""
    if hand.state is not None:
        print_line(encode(hand.state).decode())
        sys.stdout.flush()

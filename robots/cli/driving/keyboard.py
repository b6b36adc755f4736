"""Driving by the keys of a terminal, with one line that shows what the robot does."""

import asyncio
import contextlib
import os
import shutil
import sys
import termios
import tty
from collections.abc import Callable, Iterator

from ppaas.clock import monotonic
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopMode, TeleopState
from robots.cli.driving.drive_loop import drive_by
from robots.cli.driving.keys import END, GIVE_BACK, HELP, HeldKey, keys_in
from robots.cli.output import print_line, printable
from robots.client.teleop import Hand

SAID = {
    TeleopMode.READY: "ready",
    TeleopMode.DRIVING: "driving",
    TeleopMode.SLOWED: "slowed: something is near, or a limit holds here",
    TeleopMode.BLOCKED: "stopped: something is in the way",
}
"""Modes in words."""


class Keyboard:
    """Keys of a terminal; a `MotionSource`.

    Parameters
    ----------
    speed : float
        Speed at first, as a part of the robot's fastest one.
    """

    def __init__(self, speed: float) -> None:
        self.changed = asyncio.Event()
        self.held = HeldKey(speed)
        self._end = DriverRequest.NOTHING

    def press(self, text: str) -> None:
        """Take what the terminal has sent; an empty text says that it has hung up."""
        if not text:
            self._end = DriverRequest.LEAVE
        for key in keys_in(text):
            if key in END:
                self._end = DriverRequest.LEAVE
            elif key == GIVE_BACK:
                self._end = DriverRequest.GIVE_BACK
            self.held.press(key, monotonic())
        self.changed.set()

    def end(self, now: float) -> DriverRequest:
        """Return how driving ends, if it does; see `MotionSource.end`."""
        return self._end

    def velocity(self, state: TeleopState, now: float) -> tuple[float, float] | None:
        """Return the wanted velocity; see `MotionSource.velocity`."""
        motion = self.held.motion(now)
        return None if motion is None else (motion[0] * state.max_linear, motion[1] * state.max_angular)


async def drive_by_keys(hand: Hand, robot: str, speed: float) -> None:
    """Drive by the keys of this terminal.

    Raises
    ------
    Conflict
        Another has taken over, or the turn has lapsed.
    """
    keyboard = Keyboard(speed)
    print_line(HELP)
    with _keys_of_terminal(keyboard.press):
        try:
            await drive_by(hand, keyboard, lambda hand: _draw(status_line(robot, hand, keyboard.held.speed)))
        finally:
            print_line("")


@contextlib.contextmanager
def _keys_of_terminal(press: Callable[[str], None]) -> Iterator[None]:
    """Read keys as they are pressed, without an echo; Ctrl-C and Ctrl-Z are keys, so that they stop the robot."""
    file, loop = sys.stdin.fileno(), asyncio.get_running_loop()
    before = termios.tcgetattr(file)
    tty.setcbreak(file)
    keys = termios.tcgetattr(file)
    keys[3] &= ~termios.ISIG
    termios.tcsetattr(file, termios.TCSANOW, keys)
    loop.add_reader(file, lambda: press(os.read(file, 1024).decode(errors="replace")))
    try:
        yield
    finally:
        loop.remove_reader(file)
        termios.tcsetattr(file, termios.TCSADRAIN, before)


def status_line(robot: str, hand: Hand, speed: float) -> str:
    """Return what a driver sees: the velocity of the robot, the round trip of commands, and what the robot does."""
    state = hand.state
    if state is None:
        return f"{robot}: asking for the robot"
    said = SAID.get(TeleopMode(state.mode), state.mode)
    if state.mode == TeleopMode.LOCKED:
        said = f"locked: {printable(state.text)}; let go, then press again"
    trip = "-" if hand.round_trip is None else f"{hand.round_trip * 1000:.0f} ms"
    return f"{robot}  {state.linear:+.2f} m/s  {state.angular:+.2f} rad/s  speed {speed:.0%}  round trip {trip}  {said}"


def _draw(line: str) -> None:
    sys.stdout.write(f"\r\x1b[K{line[: shutil.get_terminal_size().columns - 1]}")
    sys.stdout.flush()

"""Keys of a terminal by which a robot is driven: as in teleop_twist_keyboard of ROS, or as in the dashboard.

A terminal reports presses of keys, and repeats while one is held, but no release. So a key counts for a short time
only: a press drives for `TAP` seconds, and each repeat for `GAP` seconds more. Between a press and its first repeat,
which comes after a delay that the user's keyboard sets, the robot may stand.
"""

from collections.abc import Iterator

TAP = 0.3
"""Time for which the press of a key drives [s]."""

GAP = 0.2
"""Time for which a repeat of a key drives [s]: keyboards repeat at 10 Hz at least, and links delay some repeats."""

FIRST_REPEAT = 1.0
"""Longest time from a press to the first repeat: the longest delay that keyboards have [s]."""

STEP = 1.1
"""Factor by which a key changes the speed."""

SLOWEST = 0.05
"""Smallest speed, as a part of the robot's fastest one."""

MOVES: dict[str, tuple[float, float]] = {
    "u": (1.0, 1.0), "i": (1.0, 0.0), "o": (1.0, -1.0), "j": (0.0, 1.0), "l": (0.0, -1.0),
    "m": (-1.0, -1.0), ",": (-1.0, 0.0), ".": (-1.0, 1.0),
    "w": (1.0, 0.0), "a": (0.0, 1.0), "s": (-1.0, 0.0), "d": (0.0, -1.0),
    "up": (1.0, 0.0), "left": (0.0, 1.0), "down": (-1.0, 0.0), "right": (0.0, -1.0),
}  # fmt: skip
"""Direction of each key: forward, and turning to the left."""

FASTER, SLOWER, GIVE_BACK, ESCAPE = "q", "z", "g", "escape"
END = (ESCAPE, "\x03", "\x04")
"""Keys that end driving: Escape, Ctrl-C and Ctrl-D."""

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}

HELP = """\
   u  i  o        w          arrows: as w a s d      q / z: faster / slower
   j  k  l      a s d        k, space: stop          Esc, Ctrl-C: end
   m  ,  .                   g: end, and the robot goes on to its goal
Hold a key to drive. The robot stops when the key no longer repeats."""


def keys_in(text: str) -> Iterator[str]:
    """Yield the keys of what a terminal has sent at once; those that it sends as unknown sequences as ``?``."""
    while text:
        if not text.startswith("\x1b"):
            yield text[0].lower()
            text = text[1:]
        elif text[1:2] in ("[", "O") and len(text) > 2:
            end = next((at for at, sign in enumerate(text[2:], 2) if "@" <= sign <= "~"), len(text) - 1)
            yield _ARROWS.get(text[end], "?") if end == 2 else "?"
            text = text[end + 1 :]
        else:
            yield ESCAPE
            text = text[1:]


class HeldKey:
    """The key that is held, as far as a terminal says.

    Parameters
    ----------
    speed : float
        Speed at first, as a part of the robot's fastest one.
    """

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self._key = ""
        self._at = self._until = float("-inf")

    def press(self, key: str, now: float) -> None:
        """Take a key that was pressed, or is repeated; one that does not drive stops the robot."""
        if key in (FASTER, SLOWER):
            changed = self.speed * STEP if key == FASTER else self.speed / STEP
            self.speed = min(max(changed, SLOWEST), 1.0)
        elif key not in MOVES:
            self._until = float("-inf")
        else:
            repeats = key == self._key and now - self._at <= FIRST_REPEAT
            self._key, self._at, self._until = key, now, now + (GAP if repeats else TAP)

    def motion(self, now: float) -> tuple[float, float] | None:
        """Return the parts of the fastest speeds at which the robot is to drive; None if no key is held."""
        if now >= self._until:
            return None
        linear, angular = MOVES[self._key]
        return self.speed * linear, self.speed * angular

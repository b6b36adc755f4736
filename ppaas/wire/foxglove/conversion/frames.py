"""Frames of many robots in one tree: a robot's frames below its name, and the map that robots share."""

from dataclasses import dataclass
from typing import Any

from ppaas.nodes.frames import MAP

FRAMES = ("frame_id", "child_frame_id")
"""Fields that name a frame."""


@dataclass(frozen=True, slots=True)
class SharedFrames:
    """Names of a robot's frames in the tree of all robots.

    Parameters
    ----------
    robot : str
        Name of the robot, below which its frames are.
    map : str
        Name of the frame of the map it is on; empty for its own map, which it makes.
    """

    robot: str
    map: str = ""

    def shared(self, frame: str) -> str:
        """Return a frame of the robot as it is named in the tree; no frame stays none."""
        name = frame.lstrip("/")
        if name == MAP and self.map:
            return self.map
        return name if not name or name.startswith(f"{self.robot}/") else f"{self.robot}/{name}"

    def own(self, frame: str) -> str:
        """Return a frame of the tree as the robot names it."""
        name = frame.lstrip("/")
        return MAP if self.map and name == self.map else name.removeprefix(f"{self.robot}/")

    def share_all(self, values: Any) -> None:
        """Rename the frames in a message, given as a dict."""
        _rename(values, self.shared)

    def own_all(self, values: Any) -> None:
        """Rename the frames in a message for the robot, given as a dict."""
        _rename(values, self.own)


def _rename(values: Any, rename: Any) -> None:
    """Rename the frames in a dict, and in the dicts and lists of dicts in it."""
    waiting = [values]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            for key, inner in value.items():
                if key in FRAMES and isinstance(inner, str):
                    value[key] = rename(inner)
                elif isinstance(inner, dict | list):
                    waiting.append(inner)
        elif value and isinstance(value[0], dict):
            waiting.extend(value)

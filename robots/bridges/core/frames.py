"""Frames of a robot: which are known, and which transforms the cloud needs."""

from collections.abc import Mapping, Sequence
from typing import Any

from ppaas.nodes.frames import SCAN_ODOM

HOLD = 3.0
"""Longest time for which scans wait for the transform of their frame [s]."""

REPEAT = 1.0
"""Time after which a transform that has not changed is sent again [s]."""

MAX_FRAMES = 1000
"""Largest number of frames that are remembered."""


class Frames:
    """Frames of a robot by its odometry and its transforms.

    Attributes
    ----------
    odom, base : str
        Frame in which odometry counts, and frame of the robot's body, as odometry names them.
    in_map : dict or None
        Transform of the odometry's frame in the map, as the clone last told it.
    """

    def __init__(self) -> None:
        self.odom, self.base = "odom", "base_link"
        self.in_map: Mapping[str, Any] | None = None
        self._static: dict[str, Mapping[str, Any]] = {}
        self._known: set[str] = set()
        self._waiting_since: float | None = None
        self._sent: dict[str, tuple[object, float]] = {}

    def odometry(self, message: Mapping[str, Any]) -> None:
        """Take the frames of an odometry message."""
        self.odom = message["header"]["frame_id"] or self.odom
        self.base = message["child_frame_id"] or self.base

    def may_send_scan(self, frame: str, now: float) -> bool:
        """Return whether a scan of a frame can be used: its frame is known, or was not published for `HOLD` seconds."""
        if not frame or frame in self._known or frame in (self.base, self.odom):
            return True
        if self._waiting_since is None:
            self._waiting_since = now
        return now - self._waiting_since > HOLD

    def upward(self, transforms: Sequence[Mapping[str, Any]], now: float, *, static: bool) -> list[Mapping[str, Any]]:
        """Return the transforms that the cloud needs: of the robot's parts that have changed.

        The cloud knows the body by odometry, and publishes the map itself.
        """
        wanted = []
        for transform in transforms:
            child, parent = transform["child_frame_id"].lstrip("/"), transform["header"]["frame_id"].lstrip("/")
            if child in (self.base, self.odom) or parent in ("map", SCAN_ODOM):
                continue
            if static or self._has_changed(child, parent, transform["transform"], now):
                wanted.append(transform)
        return wanted

    def sent(self, transforms: Sequence[Mapping[str, Any]]) -> None:
        """Note that the cloud gets transforms before any scan that follows."""
        if len(self._known) < MAX_FRAMES:
            self._known.update(one["child_frame_id"].lstrip("/") for one in transforms)

    def keep(self, transforms: Sequence[Mapping[str, Any]]) -> None:
        """Keep static transforms, which the robot publishes once, for new clones."""
        for one in transforms:
            if one["child_frame_id"] in self._static or len(self._static) < MAX_FRAMES:
                self._static[one["child_frame_id"]] = one

    @property
    def kept(self) -> list[Mapping[str, Any]]:
        """Static transforms of the robot."""
        return list(self._static.values())

    def downward(self, transforms: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
        """Return the transforms of the cloud that the robot lacks: its odometry in the map.

        A robot that maps without odometry gets its pose in the map, too.
        """
        odometry = [one for one in transforms if _names(one) == ("map", self.odom)]
        if odometry:
            self.in_map = odometry[-1]["transform"]
        return odometry + [one for one in transforms if SCAN_ODOM in _names(one)]

    def _has_changed(self, child: str, parent: str, value: object, now: float) -> bool:
        before = self._sent.get(child)
        if before is not None and before[0] == (parent, value) and now - before[1] < REPEAT:
            return False
        if len(self._sent) < MAX_FRAMES:
            self._sent[child] = (parent, value), now
        return True


def _names(transform: Mapping[str, Any]) -> tuple[str, str]:
    """Return parent and child of a transform."""
    return transform["header"]["frame_id"], transform["child_frame_id"]

"""Parameters of the node ``recorder`` in a robot file."""

from fnmatch import fnmatchcase
from functools import lru_cache
from typing import Annotated, Any

from msgspec import Meta

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters

NAME = "recorder"

EVERYTHING = "*"
"""Glob that stands for all topics except `HEAVY`."""

HEAVY = (
    "camera/*",
    "cloud_in",
    "particlecloud",
    "octomap_*",
    "projected_map",
    "key_frames",
    "local_plan",
    "global_costmap/*",
    "move_base/global_costmap/*",
    "move_base/local_costmap/*",
    "tf2_web_republisher/*",
    "diagnostics",
)
"""Topics that are recorded only if a glob names them: large ones, those that repeat others, and those that the clone
computes only while somebody subscribes."""

MOST_MINUTES = 60.0
"""Longest ring [min]."""

MOST_MB = 512
"""Largest ring of a robot [MB]."""

Glob = Annotated[str, Meta(min_length=1, max_length=128, pattern=r"^[A-Za-z0-9_.*?\[\]!~/-]+$")]
Globs = Annotated[tuple[Glob, ...], Meta(min_length=1, max_length=64)]


class RecorderParameters(Parameters, frozen=True):
    """Parameters of the recorder.

    Parameters
    ----------
    ring_minutes : float
        Length of the ring of the last minutes [min]; 0 for no ring.
    topics : tuple of str
        Globs of the topics that are recorded; ``*`` stands for all but `HEAVY`.
    max_mb : int
        Largest size of the ring on the disk [MB].
    """

    ring_minutes: Annotated[float, Meta(ge=0.0, le=MOST_MINUTES)] = 0.0
    topics: Globs = (EVERYTHING,)
    max_mb: Annotated[int, Meta(ge=1, le=MOST_MB)] = 64

    @property
    def ring_seconds(self) -> float:
        """Length of the ring [s]."""
        return 60.0 * self.ring_minutes


def recorder_parameters(table: Any) -> RecorderParameters:
    """Return the parameters in a table of a robot file.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, or its value is invalid.
    """
    return read_parameters(RecorderParameters, NAME, table)


def checked_globs(globs: tuple[str, ...]) -> tuple[str, ...]:
    """Return globs without leading slashes.

    Raises
    ------
    InvalidParameter
        There is none, there are too many, or one is no glob.
    """
    try:
        return tuple(glob.removeprefix("/") for glob in recorder_parameters({"topics": list(globs)}).topics)
    except InvalidParameter as error:
        raise InvalidParameter(f"topics to record: {error}") from error


@lru_cache(maxsize=4096)  # it is asked for each message
def selects(globs: tuple[str, ...], topic: str) -> bool:
    """Return whether globs select a topic for recording."""
    return any(
        fnmatchcase(topic, glob) and not (glob == EVERYTHING and any(fnmatchcase(topic, heavy) for heavy in HEAVY))
        for glob in globs
    )

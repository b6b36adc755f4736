"""Options of a fleet for Open-RMF, and the file with its reference points."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from ppaas.errors import InvalidInput
from ppaas.wire.rmf.level_frame import LevelFrame

MOST_BYTES = 1 << 20
"""Largest file of reference points [bytes]."""


@dataclass(frozen=True, slots=True)
class FleetForRmf:
    """Options of a fleet.

    Parameters
    ----------
    name : str
        Name of the fleet in RMF.
    names : mapping of str to str
        Names of robots in RMF by their ids in the cloud; a robot without one has its id as name.
    levels : mapping of str to str
        Names of levels by the id of the map; a map without one has its id as name.
    frames : mapping of str to LevelFrame
        Frames by the name of the level; without one, both frames are the same.
    period : float
        Time between two states [s].
    """

    name: str
    names: Mapping[str, str] = field(default_factory=dict)
    levels: Mapping[str, str] = field(default_factory=dict)
    frames: Mapping[str, LevelFrame] = field(default_factory=dict)
    period: float = 0.5


def read_frames(content: bytes) -> dict[str, LevelFrame]:
    """Return the frames of levels from ``reference_coordinates`` of YAML, as configurations of fleet adapters have it.

    Raises
    ------
    InvalidInput
        The content is not such YAML; the text names the level.
    """
    if len(content) > MOST_BYTES:
        raise InvalidInput(f"reference points are read from files up to {MOST_BYTES} bytes")
    try:
        document = yaml.safe_load(content)
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
        raise InvalidInput(f"reference points must be YAML: {error}") from error
    found = document.get("reference_coordinates") if isinstance(document, dict) else None
    if not isinstance(found, dict) or not found:
        raise InvalidInput(
            "no 'reference_coordinates' are in the file: it must have points in 'rmf' and 'robot' by level"
        )
    return {str(level): _frame(str(level), points) for level, points in found.items()}


def _frame(level: str, points: Any) -> LevelFrame:
    try:
        rmf, robot = ([(float(x), float(y)) for x, y in points[side]] for side in ("rmf", "robot"))
    except (TypeError, ValueError, KeyError) as error:
        raise InvalidInput(f"level {level!r}: 'rmf' and 'robot' must be lists of [x, y]: {error!r}") from error
    try:
        return LevelFrame.of(rmf, robot)
    except InvalidInput as error:
        raise InvalidInput(f"level {level!r}: {error}") from error

"""Replays a recording to localization, and compares the estimates with the recorded true poses.

Also what a replay needs: noise of odometry, a map from scans with known poses, and a picture.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.map_figure import map_figure
from benchmarks.localization.localizer import Localizer
from benchmarks.localization.run import LOST, LOST_TURN, found_after, held_from
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.beams import scan_points
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from robots.pictures.figure_file import write_figure
from robots.recordings.recording import Look, Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Replay:
    """Estimates of localization for a recording.

    Parameters
    ----------
    looks : tuple of Look
        Scans that localization processed.
    told : tuple of Pose2D
        Estimated pose of the robot in the map frame at each scan.
    seconds : float
        Mean time to process a scan [s].
    """

    looks: tuple[Look, ...]
    told: tuple[Pose2D, ...]
    seconds: float


def play(
    recording: Recording,
    grid: GridMap,
    parameters: dict[str, Any],
    *,
    scans: Sequence[int],
    anywhere: bool,
    done: Callable[[], None],
) -> Replay:
    """Replay a recording.

    Parameters
    ----------
    recording : Recording
    grid : GridMap
        Map in the frame of the true poses.
    parameters : dict
        Parameters of amcl.
    scans : sequence of int
        Indices of the scans that localization gets; it gets all of the odometry.
    anywhere : bool
        Whether to start with an unknown pose.
    done : callable
        Called after each scan of the recording.

    Raises
    ------
    InvalidInput
        The recording has no true start pose, and ``anywhere`` is False.
    """
    start = recording.looks[scans[0]].true
    if start is None and not anywhere:
        raise InvalidInput("the recording has no true pose of its robot at the start: give --global")
    localizer = Localizer(build_layers(grid), start or Pose2D(*grid.info.origin), parameters)
    if anywhere:
        localizer.look_everywhere()
    heard, looks, told = set(scans), [], []
    for number, look in enumerate(recording.looks):
        localizer.odometry(_odometry(look))
        pose = localizer.scan(_stamped(look, localizer.frame_of(look.laser))) if number in heard else None
        if pose is not None:
            looks.append(look)
            told.append(pose)
        done()
    return Replay(tuple(looks), tuple(told), float(np.mean(localizer.seconds)))


def summary(replay: Replay, *, anywhere: bool) -> dict[str, Any]:
    """Return the errors of a replay; they are null if true poses are unknown, or if the robot was not found."""
    true = [look.true for look in replay.looks if look.true is not None]
    told = {"scans": len(replay.told), "update_ms": round(1e3 * replay.seconds, 3)}
    if len(true) != len(replay.told):
        return told | dict.fromkeys(("metres", "lost", "lost_scans", "found_m", *_errors(np.empty(0), np.empty(0))))
    gaps = [before.distance_to(after) for before, after in pairwise(true)]
    way = np.concatenate(((0.0,), np.cumsum(gaps)))
    error = np.array([a.distance_to(b) for a, b in zip(replay.told, true, strict=True)])
    turn = np.array([abs(wrap_angle(a.theta - b.theta)) for a, b in zip(replay.told, true, strict=True)])
    fine = (error <= LOST) & (turn <= LOST_TURN)
    found = found_after(way, fine) if anywhere else 0.0
    # By scan, not by distance: a robot that stands drives no distance.
    since = 0 if not anywhere else len(way) if found is None else held_from(fine)
    return told | {
        "metres": round(float(way[-1]), 1),
        "lost": found is None or not bool(fine[since:].all()),
        "lost_scans": int((~fine).sum()),
        "found_m": None if found is None else round(found, 2),
        **_errors(error[since:], turn[since:]),
    }


def _errors(error: NDArray[np.float64], turn: NDArray[np.float64]) -> dict[str, float | None]:
    measures: dict[str, Callable[[NDArray[np.float64]], Any]] = {
        "error": np.mean, "p95": lambda values: np.percentile(values, 95), "worst": np.max,
    }  # fmt: skip
    return {
        f"{name}_{unit}": round(float(measure(scale * values)), 2) if len(values) else None
        for name, measure in measures.items()
        for unit, scale, values in (("cm", 100.0, error), ("deg", 180.0 / math.pi, turn))
    }


def _odometry(look: Look) -> Odometry:
    header = Header(stamp=Time.of(look.stamp), frame_id="odom")
    return Odometry(header, "base_link", PoseWithCovariance(Pose.of(look.odom)), TwistWithCovariance(Twist()))


def _stamped(look: Look, frame: str) -> Any:
    header = Header(stamp=Time.of(look.stamp), frame_id=frame)
    return msgspec.structs.replace(look.scan, header=header)


def drifting(recording: Recording, drift: float, seed: int) -> Recording:
    """Return the same drive with noise added to the odometry.

    Parameters
    ----------
    recording : Recording
    drift : float
        Standard deviation of the noise of each motion, relative to its length and its turn. The turn gets additional
        noise of a tenth of ``drift`` for each metre [rad].
    seed : int
        Seed of the noise.
    """
    random = np.random.default_rng(seed)
    looks = list(recording.looks[:1])
    for before, after in pairwise(recording.looks):
        motion = before.odom.inverse() @ after.odom
        longer, turned, aside = (drift * random.standard_normal(3)).tolist()
        turn = motion.theta * turned + 0.1 * aside * math.hypot(motion.x, motion.y)
        moved = Pose2D(motion.x * (1.0 + longer), motion.y * (1.0 + longer), motion.theta + turn)
        looks.append(replace(after, odom=looks[-1].odom @ moved))
    return replace(recording, looks=tuple(looks))


# -- map from scans with known poses -----------------------------------------------------------------------------------

RESOLUTION = 0.05
FARTHEST = 20.0
"""Maximum range of scans [m]."""
OFTEN = 0.25
"""Share of the rays at a cell that must end in it for a wall, as in gmapping."""
MARGIN = 1.0
"""Margin around the endpoints of all rays [m]."""
MOST_CELLS = 1 << 26
"""Largest number of cells of a map."""


def map_of(looks: Sequence[Look]) -> GridMap:
    """Return the map of some scans.

    Parameters
    ----------
    looks : sequence of Look
        Scans with their true poses.

    Raises
    ------
    InvalidInput
        No scan has a hit, the map would be too large, or a true pose is unknown.
    """
    rays = []
    for look in looks:
        if look.true is None:
            raise InvalidInput("the recording has no true poses from which a map could be made: give --map")
        eye = look.true @ look.laser
        ends = scan_points(look.scan, eye)
        near = np.hypot(*(ends - (eye.x, eye.y)).T) < FARTHEST
        rays.append((eye, ends[near]))
    info = _size(np.concatenate([ends for _, ends in rays]))
    ended, passed = (np.zeros(info.width * info.height, np.int32) for _ in range(2))
    for eye, ends in rays:
        ended[_cells(ends, info)] += 1
        passed[_cells(_along(eye, ends), info)] += 1
    cells = np.where(ended + passed == 0, UNKNOWN, np.where(ended > OFTEN * (ended + passed), OCCUPIED, FREE))
    return GridMap(cells.astype(np.int8).reshape(info.height, info.width), info)


def _size(ends: NDArray[np.float64]) -> GridInfo:
    if not len(ends):
        raise InvalidInput("the scans of the recording hit nothing, so no map can be made of them: give --map")
    low, high = ends.min(axis=0) - MARGIN, ends.max(axis=0) + MARGIN
    width, height = (math.ceil(extent / RESOLUTION) for extent in (high - low).tolist())
    if width * height > MOST_CELLS:
        raise InvalidInput(f"a map of {width} × {height} cells is too large: give --map")
    return GridInfo(RESOLUTION, width, height, Pose2D(float(low[0]), float(low[1])))


def _along(eye: Pose2D, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 2) points along the rays, half a cell apart, up to one cell before their endpoints."""
    gaps = ends - (eye.x, eye.y)
    lengths = np.hypot(*gaps.T)
    counts = np.maximum(np.floor((lengths - RESOLUTION) / (RESOLUTION / 2.0)), 0.0).astype(np.int64)
    ray = np.repeat(np.arange(len(ends)), counts)
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    points: NDArray[np.float64] = (eye.x, eye.y) + gaps[ray] * (number * (RESOLUTION / 2.0) / lengths[ray])[:, None]
    return points


def _cells(points: NDArray[np.float64], info: GridInfo) -> NDArray[np.int64]:
    """Return the indices of the cells that contain points, without duplicates."""
    column, row = np.floor((points - (info.origin.x, info.origin.y)) / info.resolution).astype(np.int64).T
    inside = (column >= 0) & (column < info.width) & (row >= 0) & (row < info.height)
    return np.unique(row[inside] * info.width + column[inside])


# -- picture of a replayed recording -----------------------------------------------------------------------------------

TRUE, ESTIMATED, ERROR = "#148c55", "#175fd6", "#cd264a"

LARGE_ERROR = 0.25
"""Smallest error that is drawn as a line from the true to the estimated position [m]."""


def write_picture(path: Path, grid: GridMap, replay: Replay) -> None:
    """Draw a replay into a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    write_figure(path, draw(grid, replay))


def draw(grid: GridMap, replay: Replay) -> "Figure":
    """Return the picture: the true path in green, the estimated one in blue, and large errors in red."""
    figure, axes = map_figure(grid)
    pairs = [(look.true, told) for look, told in zip(replay.looks, replay.told, strict=True)]
    for true, estimated in pairs:
        if true is not None and true.distance_to(estimated) >= LARGE_ERROR:
            axes.plot([true.x, estimated.x], [true.y, estimated.y], color=ERROR, linewidth=0.8)
    for label, poses, colour, width in (
        ("estimated", [estimated for _, estimated in pairs], ESTIMATED, 2.0),
        ("true", [true for true, _ in pairs if true is not None], TRUE, 1.0),
    ):
        axes.plot([pose.x for pose in poses], [pose.y for pose in poses], color=colour, linewidth=width, label=label)
    figure.legend(loc="outside upper left", ncols=2, frameon=False)
    return figure

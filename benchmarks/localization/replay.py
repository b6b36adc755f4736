"""Replays a recording to localization, and compares the estimates with the recorded true poses."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.localization.localizer import Localizer
from benchmarks.localization.run import LOST, LOST_TURN, found_after, held_from
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from robots.recordings.recording import Look, Recording


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

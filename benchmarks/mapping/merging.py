"""Bench of merging: halves of one log, mapped apart, and pairs of different buildings, which must not be merged.

``python -m benchmarks.mapping.merging [LOG …] [--pairs]``: the halves of each log and of the simulated office are
mapped without a common start and merged. Relative poses of scans of different halves that are less than 3 m apart are
compared with the same log mapped whole, with the true poses if it is simulated, and with the true relations of the file
beside the log that ends with ``.relations``. ``--pairs`` tries to merge every two of the logs, the office, its mirror
image and corridors. Times are CPU times of one thread [s].
"""

import argparse
import itertools
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from benchmarks.mapping.merge_worlds import WORLDS
from benchmarks.mapping.ring import ring_drive
from benchmarks.mapping.true_error import random_relations
from ppaas.errors import MapsNotMerged
from ppaas.mapping.merging.merge import Merged, merge
from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.relations import Relations, parse_relations, score
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import PoseArray, compose, inverse, relative
from robots.recordings.scan_logs import read_scan_log

ELSEWHERE = np.array((31.0, -12.0, 2.2))
"""Motion of the odometry of the second half: x, y [m], theta [rad]."""

SEED = 1
"""Seed of the choice of relations."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Log, with what is known of it.

    Parameters
    ----------
    name : str
    log : ScanLog
    true : (n, 3) array, optional
        True poses of the robot.
    relations : Relations, optional
        True relations.
    """

    name: str
    log: ScanLog
    true: PoseArray | None = None
    relations: Relations | None = None


def main() -> None:
    """Print the results as JSON, one line each."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("logs", nargs="*", type=Path)
    parser.add_argument("--pairs", action="store_true", help="try to merge different buildings")
    options = parser.parse_args()
    drives = [*map(read_drive, options.logs), world_drive("office")]
    warm_up()
    rows: Iterator[dict[str, Any]] = map(halves, drives)
    if options.pairs:
        others = [world_drive(name) for name in WORLDS if name != "office"]
        rows = itertools.chain(rows, pairs([*drives, *others]))
    for row in rows:
        print(json.dumps(row), flush=True)  # noqa: T201 - the output of the bench


def read_drive(path: Path) -> Drive:
    """Return the log of a file, with the relations of the file beside it."""
    name = path.name.partition(".")[0]
    beside = path.with_name(f"{name}.relations")
    relations = parse_relations(beside.read_text("ascii")) if beside.is_file() else None
    return Drive(name, read_scan_log(path), None, relations)


def world_drive(name: str) -> Drive:
    """Return a simulated drive through a world of `WORLDS`."""
    drive = WORLDS[name]()
    return Drive(name, drive.log, drive.true)


def warm_up() -> None:
    """Merge halves of a small drive, so that the kernels are compiled or loaded."""
    first, second = divided(ring_drive(4).log)
    merge(mapping_of(map_log(first)), mapping_of(map_log(second)))


def halves(drive: Drive) -> dict[str, Any]:
    """Return the time and the errors of a merge of the halves of a drive."""
    log = drive.log
    first, second = (map_log(part) for part in divided(log))
    begin = process_time()
    try:
        merged = merge(mapping_of(first), mapping_of(second))
    except MapsNotMerged as error:
        return {"halves": drive.name, "merged": False, "cpu_s": round(process_time() - begin, 2), "why": str(error)}
    seconds, poses = process_time() - begin, scan_poses(merged, first, second)
    answer = {
        "halves": drive.name,
        "merged": True,
        "cpu_s": round(seconds, 2),
        "places": merged.matches,
        "support": round(merged.support, 3),
        "confirmed": round(merged.confirmed, 4),
        "against_whole": errors(_between(log, map_log(log).poses), log, poses),
    }
    if drive.true is not None:
        answer["against_truth"] = errors(_between(log, drive.true), log, poses)
    if drive.relations is not None:
        answer["against_relations"] = errors(_across(drive.relations, log), log, poses)
    return answer


def pairs(drives: Sequence[Drive]) -> Iterator[dict[str, Any]]:
    """Yield the result of a merge of each two drives through different buildings, in both directions."""
    made = cache(lambda at: mapping_of(map_log(drives[at].log)))
    for one, other in itertools.permutations(range(len(drives)), 2):
        begin = process_time()
        try:
            merged, why = bool(merge(made(one), made(other))), ""
        except MapsNotMerged as error:
            merged, why = False, str(error)
        yield {
            "different": [drives[one].name, drives[other].name],
            "merged": merged,
            "cpu_s": round(process_time() - begin, 2),
            "why": why,
        }


def divided(log: ScanLog) -> tuple[ScanLog, ScanLog]:
    """Return the halves of a log; the odometry of the second one has another origin."""
    middle = len(log) // 2
    rest = replace(
        log,
        stamps=log.stamps[middle:],
        odometry=compose(ELSEWHERE, log.odometry[middle:]),
        ranges=log.ranges[middle:],
        first_angles=log.first_angles[middle:],
    )
    return log.first(middle), rest


def mapping_of(made: LogMap) -> Mapping:
    """Return the mapping of a log."""
    return Mapping(made.mapper.key_frames, made.mapper.graph)


def scan_poses(merged: Merged, *parts: LogMap) -> PoseArray:
    """Return the poses of the robot at all scans: each moves with the key frame before it."""
    found, at = [], 0
    for part in parts:
        frames = part.mapper.key_frames
        mount = inverse(np.array(frames.geometry.mount))
        before = np.searchsorted(frames.scans, np.arange(len(part.poses)), side="right") - 1
        within = relative(compose(frames.poses, mount)[before], part.poses)
        moved = compose(merged.mapping.frames.poses[at : at + len(frames)], mount)
        found.append(compose(moved[before], within))
        at += len(frames)
    return np.concatenate(found)


def errors(relations: Relations, log: ScanLog, poses: PoseArray) -> dict[str, float | int]:
    """Return the errors of poses by relations."""
    return score(relations, log.stamps, poses).summary()


def _between(log: ScanLog, poses: PoseArray) -> Relations:
    """Return relations between near poses of different halves of a log."""
    return _across(random_relations(log.stamps, poses, SEED, most=6000), log)


def _across(relations: Relations, log: ScanLog) -> Relations:
    """Return the relations between scans of different halves of a log."""
    middle = log.stamps[len(log) // 2]
    before = relations.stamps < middle
    chosen = before[:, 0] != before[:, 1]
    return Relations(relations.stamps[chosen], relations.poses[chosen])


if __name__ == "__main__":
    main()

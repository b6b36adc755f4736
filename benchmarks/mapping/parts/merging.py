"""Part ``merging``: halves of one log, mapped apart without a common start, and merged.

Relative poses of scans of different halves that are less than 3 m apart are compared with the same log mapped whole,
with the true poses if it is simulated, and with the true relations of the file beside the log.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.map_errors import random_relations
from benchmarks.mapping.parts.mapped import mapped, mapping_of
from benchmarks.mapping.parts.part import SlamOptions, name_of, relations_of
from benchmarks.mapping.small_worlds import ring_drive
from benchmarks.mapping.worlds import OFFICE, drive_of
from ppaas.errors import MapsNotMerged
from ppaas.mapping.merging.merge import Merged, merge
from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.relations import Relations, parse_relations, score
from ppaas.mapping.scan_log import ScanLog
from ppaas.planar_poses import PoseArray, compose, inverse, relative
from robots.recordings.scan_logs import read_scan_log

ELSEWHERE = np.array((31.0, -12.0, 2.2))
"""Motion of the odometry of the second half: x, y [m], theta [rad]."""

SEED = 1
"""Seed of the choice of relations."""


TIME_LIMIT, ERROR_LIMIT = 5.0, 0.03
"""Largest CPU time of a merge [s], and largest mean error of relations between the halves [m]."""

AGAINST = {
    "against_whole": "by the whole log",
    "against_truth": "by the true poses",
    "against_relations": "by the true relations",
}
"""Sources of relations between the halves, and their names."""


@dataclass(frozen=True, slots=True)
class DriveLog:
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


def measure(options: SlamOptions) -> PartResult:
    """Merge the halves of the logs, of those of the folder of data that have true relations, and of the office."""
    warm_up()
    drives = [*map(read_drive, options.with_relations()), *([office_drive()] if options.worlds else [])]
    results = [halves(drive, options.folder) for drive in drives]
    return PartResult([figure for result in results for figure in figures_of(result)], list(map(row, results)), results)


def read_drive(path: Path) -> DriveLog:
    """Return the log of a file, with the relations of the file beside it."""
    beside = relations_of(path)
    relations = parse_relations(beside.read_text("ascii")) if beside.is_file() else None
    return DriveLog(name_of(path), read_scan_log(path), None, relations)


def office_drive() -> DriveLog:
    """Return a drive through the office."""
    drive = drive_of(OFFICE, 0)
    return DriveLog(f"{OFFICE} 0", drive.log, drive.true)


def warm_up() -> None:
    """Merge halves of a small drive, so that the kernels are compiled or loaded."""
    first, second = divided(ring_drive(4).log)
    merge(mapping_of(map_log(first)), mapping_of(map_log(second)))


def halves(drive: DriveLog, folder: Path) -> dict[str, Any]:
    """Return the time and the errors of a merge of the halves of a drive; see `mapped` for the folder."""
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
        "against_whole": errors(_between(log, mapped(folder, drive.name, lambda: log).poses), log, poses),
    }
    if drive.true is not None:
        answer["against_truth"] = errors(_between(log, drive.true), log, poses)
    if drive.relations is not None:
        answer["against_relations"] = errors(_across(drive.relations, log), log, poses)
    return answer


def figures_of(result: dict[str, Any]) -> list[Figure]:
    """Return the time and the errors of a merge; a merge that was refused has neither."""
    name = f"halves of {result['halves']}"
    if not result["merged"]:
        return [Figure("merging", f"{name}: merged", 0, "", limit=1.0, floor=True, note=result["why"])]
    note = f"{result['places']} places agree, {100.0 * result['support']:.0f} % of the scans fit"
    figures = [Figure("merging", f"{name}: time", result["cpu_s"], "s", limit=TIME_LIMIT, note=note)]
    for against, name_of_truth in AGAINST.items():
        if found := result.get(against):
            limit = ERROR_LIMIT if against == "against_whole" else None
            note = f"± {found['std_m']:.4f}, largest {found['max_m']:.2f} m, of {found['relations']}, {name_of_truth}"
            figures.append(Figure("merging", f"{name}: cross relations", found["mean_m"], "m", limit=limit, note=note))
    return figures


def row(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    merged = result["merged"]
    return {
        "halves": result["halves"],
        "cpu s": f"{result['cpu_s']:.1f}",
        "places": str(result["places"]) if merged else "",
        "scans that fit": f"{100.0 * result['support']:.0f} %" if merged else "",
        "points confirmed": f"{100.0 * result['confirmed']:.1f} %" if merged else "",
        **{f"{against.replace('_', ' ')} m": _text(result.get(against)) for against in AGAINST},
        "refused": result.get("why", ""),
    }


def _text(found: dict[str, Any] | None) -> str:
    return f"{found['mean_m']:.4f} ± {found['std_m']:.4f} (max {found['max_m']:.2f})" if found else ""


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

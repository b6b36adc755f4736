"""Bench of 3D maps that move with key frames, on depth images with poses.

``python -m benchmarks.mapping.moved_volume FOLDER [--images N]``, FOLDER as in ``benchmarks.mapping.volume``. The poses
get a drift in the plane, which a correction takes away. The corrected map is compared with one that is made with the
true poses; and noise of single poses is taken away by registration (extra ``mapping``).
"""

import argparse
import json
import math
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.volume import PARAMETERS, Cloud, depth_clouds
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.exports import binary_file
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.mapping.volume.registration import CloudRegistration, apply
from ppaas.mapping.volume.submap_volume import SubmapVolume
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.transforms.spatial import Rigid, matrix_of

DRIFTS = ((0.0, 0.0), (0.1, 1.0), (0.3, 3.0))
"""Drift at the last image: distance [m] and angle [°]. That of an image is of the tenth part of the drive it is in."""

NOISE = 0.02
"""Standard deviation of the noise of single poses [m, rad]."""

FARTHEST = 4.0
"""Range up to which clouds are registered [m]."""


def main() -> None:
    """Print the results as JSON, one line each."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--images", type=int, default=84)
    options = parser.parse_args()
    clouds = depth_clouds(options.folder, options.images)
    for result in (*corrections(clouds), registration(clouds)):
        print(json.dumps(result))  # noqa: T201 - the output of the bench


def corrections(clouds: list[Cloud]) -> list[dict[str, Any]]:
    """Return for each drift how far the map is from that of the true poses, before and after the correction."""
    fresh = VoxelVolume(PARAMETERS)
    for points, origin in clouds:
        fresh.insert(points, origin)
    return [_correction(clouds, fresh, *drift) for drift in DRIFTS]


def _correction(clouds: list[Cloud], fresh: VoxelVolume, distance: float, angle: float) -> dict[str, Any]:
    count = len(clouds)
    parts = [math.floor(10 * i / count) / 10.0 for i in range(count)]
    drifts = [Pose2D(distance * part, 0.5 * distance * part, math.radians(angle) * part) for part in parts]
    stamps, true = np.arange(float(count)), np.array([[*origin[:2], 0.0] for _, origin in clouds])
    before = KeyFramePoses(stamps, np.array([drift @ Pose2D(*pose) for drift, pose in zip(drifts, true, strict=True)]))
    volume, begin = SubmapVolume(PARAMETERS, submap_travel=0.5), process_time()  # the room is small
    for index, ((points, origin), drift) in enumerate(zip(clouds, drifts, strict=True)):
        motion = matrix_of(Rigid.planar(drift))
        volume.insert(apply(motion, points), apply(motion, origin[None])[0], before.anchor(stamps[index]))
    inserted = process_time() - begin
    drifted, begin = _equality(volume.volume, fresh), perf_counter()
    volume.correct(before, KeyFramePoses(stamps, true))
    corrected = perf_counter() - begin
    begin = perf_counter()
    size = len(binary_file(volume.volume))
    return {
        "drift_m": distance, "drift_deg": angle, "images": count, "submaps": len(volume.submaps),
        "blocks": len(volume), "blocks_of_map": len(volume.volume.blocks),
        "points_per_cpu_s": round(sum(len(points) for points, _ in clouds) / inserted),
        "correction_s": round(corrected, 3), "file_s": round(perf_counter() - begin, 3), "file_bytes": size,
        "drifted": drifted, "corrected": _equality(volume.volume, fresh),
    }  # fmt: skip


def _equality(volume: VoxelVolume, fresh: VoxelVolume) -> dict[str, float]:
    """Return the part of known voxels of equal occupancy, and of occupied ones within a voxel of the other map's."""
    (ours, held), (theirs, wanted) = _voxels(volume), _voxels(fresh)
    _, first, second = np.intersect1d(_codes(ours), _codes(theirs), assume_unique=True, return_indices=True)
    every = len(ours) + len(theirs) - len(first)
    near = min(_part_near(ours[held], theirs[wanted]), _part_near(theirs[wanted], ours[held]))
    return {"equal": round(float((held[first] == wanted[second]).sum()) / every, 4), "within_a_voxel": round(near, 4)}


def _voxels(volume: VoxelVolume) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the keys of the known voxels (n, 3), and whether each is occupied."""
    slots, voxels = np.nonzero(~np.isnan(volume.blocks.log_odds))
    keys = volume.blocks.corners[slots] + np.stack([voxels % 8, voxels // 8 % 8, voxels // 64], axis=1)
    return keys, volume.blocks.log_odds[slots, voxels] >= 0.0


def _codes(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.asarray(keys[:, 2] << 32 | keys[:, 1] << 16 | keys[:, 0])


def _part_near(keys: NDArray[np.int64], others: NDArray[np.int64]) -> float:
    """Return the part of keys (n, 3) that are at most a voxel from one of the others."""
    around = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3)
    wanted = _codes(others)
    return float(np.any([np.isin(_codes(keys + step), wanted) for step in around], axis=0).mean())


def registration(clouds: list[Cloud]) -> dict[str, Any]:
    """Return the errors of noisy poses without and with registration, absolute and relative to the pose before."""
    random, aligned = np.random.default_rng(0), CloudRegistration()
    errors: dict[str, list[float]] = {"noisy_m": [], "registered_m": [], "noisy_step_m": [], "registered_step_m": []}
    last = (np.eye(4), np.eye(4))
    begin = process_time()
    for index, (points, origin) in enumerate(clouds):
        wrong = _noise(origin.astype(np.float64), random) if index else np.eye(4)
        noisy = apply(wrong, points)
        found = aligned.correction(noisy[np.linalg.norm(noisy - origin, axis=1) <= FARTHEST]) @ wrong
        for name, pose, before in (("noisy", wrong, last[0]), ("registered", found, last[1])):
            if index:
                errors[f"{name}_m"].append(_distance(pose, points[::50]))
                errors[f"{name}_step_m"].append(_distance(np.linalg.inv(before) @ pose, points[::50]))
        last = wrong, found
    spent = (process_time() - begin) / len(clouds)
    return {name: round(float(np.mean(values)), 4) for name, values in errors.items()} | {"cpu_s": round(spent, 3)}


def _noise(centre: NDArray[np.float64], random: np.random.Generator) -> NDArray[np.float64]:
    """Return a small motion about a point."""
    axis = random.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis) * math.sin(NOISE / 2.0)
    turn = matrix_of(Rigid(0.0, 0.0, 0.0, x, y, z, math.cos(NOISE / 2.0)))
    turn[:3, 3] = centre + random.normal(size=3) * NOISE - turn[:3, :3] @ centre
    return turn


def _distance(pose: NDArray[np.float64], points: NDArray[np.float32]) -> float:
    """Return the root mean square distance by which a motion moves points [m]."""
    away = points @ pose[:3, :3].T + pose[:3, 3] - points
    return float(np.sqrt((away**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()

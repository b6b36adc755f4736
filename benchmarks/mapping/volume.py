"""Bench of 3D mapping: points a second on one and two threads, beside OctoMap's own algorithm on hash sets.

``python -m benchmarks.mapping.volume [FOLDER] [--images N]``: FOLDER has depth images ``*.depth.png`` in mm with poses
``*.pose.txt`` (4 × 4, camera to map) and ``camera-intrinsics.txt``. Without it, scans of a simulated hall are used.
Times are CPU times [s] and wall times: on a machine that does other work, only the former can be compared.

In that algorithm, each ray is traversed voxel by voxel (``computeRayKeys``), and its keys go into a set; a dict holds
the log-odds.
"""

import argparse
import json
import math
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numba import njit, types
from numba.typed import Dict
from numpy.typing import NDArray

from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.perception.depth_scan import PinholeCamera

MIDDLE = 32768
_FACTOR = np.int64(-7046029254386353131)


@njit(nogil=True)
def code_of(x: Any, y: Any, z: Any) -> Any:
    """Return a number for a key, whose low bits depend on all axes: numba's sets and dicts use them as hash."""
    code = (z << 32 | y << 16 | x) * _FACTOR
    return code ^ (code >> 32 & 0xFFFFFFFF)


@njit(nogil=True)
def _cast(free, origin, end, resolution):  # type: ignore[no-untyped-def]
    """Add the voxels that a ray passes to a set; return the code of its last one."""
    factor = 1.0 / resolution
    key, last, step = np.empty(3, np.int64), np.empty(3, np.int64), np.zeros(3, np.int64)
    reach, spacing = np.full(3, np.inf), np.full(3, np.inf)
    for i in range(3):
        key[i], last[i] = math.floor(factor * origin[i]) + MIDDLE, math.floor(factor * end[i]) + MIDDLE
    target = code_of(last[0], last[1], last[2])
    code = code_of(key[0], key[1], key[2])
    if code == target:
        return target
    free.add(code)
    dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
    length = np.float32(math.sqrt(np.float64(dx * dx + dy * dy + dz * dz)))
    half = np.float64(np.float32(resolution * 0.5))
    for i in range(3):
        direction = np.float64((end[i] - origin[i]) / length)
        if direction != 0.0:
            step[i] = 1 if direction > 0.0 else -1
            reach[i] = ((key[i] - MIDDLE + 0.5) * resolution + step[i] * half - origin[i]) / direction
            spacing[i] = resolution / abs(direction)
    while True:
        axis = 0 if reach[0] < reach[1] else 1
        axis = axis if reach[axis] < reach[2] else 2
        key[axis] += step[axis]
        reach[axis] += spacing[axis]
        code = code_of(key[0], key[1], key[2])
        if code == target or min(reach[0], reach[1], reach[2]) > length:
            return target
        free.add(code)


@njit(nogil=True)
def _insert(voxels, points, origin, lengths, model):  # type: ignore[no-untyped-def]
    resolution, max_range = lengths
    free = {np.int64(-1)}
    occupied = {np.int64(-1)}
    most = np.float32(max_range)
    for i in range(len(points)):
        end = points[i].copy()
        dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
        distance = math.sqrt(np.float64(dx * dx + dy * dy + dz * dz))
        hit = distance <= max_range
        if not hit:
            for axis in range(3):
                end[axis] = origin[axis] + (end[axis] - origin[axis]) / np.float32(distance) * most
        last = _cast(free, origin, end, resolution)
        if hit:
            occupied.add(last)
    free.discard(np.int64(-1))
    occupied.discard(np.int64(-1))
    for code in free:
        if code not in occupied:
            voxels[code] = min(max(voxels.get(code, np.float32(0.0)) + model[1], model[2]), model[3])
    for code in occupied:
        voxels[code] = min(max(voxels.get(code, np.float32(0.0)) + model[0], model[2]), model[3])


@njit(nogil=True)
def _copy(voxels, codes, values):  # type: ignore[no-untyped-def]
    for i, (code, value) in enumerate(voxels.items()):
        codes[i], values[i] = code, value


class SetVolume:
    """Log-odds of voxels in a dict by the code of their keys, see `code_of`."""

    def __init__(self, resolution: float, max_range: float, model: tuple[np.float32, ...]) -> None:
        self._lengths, self._model = (resolution, max_range), tuple(model)
        self._voxels = Dict.empty(types.int64, types.float32)

    def insert(self, points: NDArray[np.float32], origin: NDArray[np.float32]) -> None:
        """Add a point cloud."""
        _insert(self._voxels, points, origin, self._lengths, self._model)

    def log_odds(self) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return the codes of the known voxels, sorted, and their log-odds, (n,) each."""
        codes, values = np.empty(len(self._voxels), np.int64), np.empty(len(self._voxels), np.float32)
        _copy(self._voxels, codes, values)
        order = np.argsort(codes)
        return codes[order], values[order]


PARAMETERS = VolumeParameters(resolution=0.05, max_range=10.0)
THREADS = (1, 2)
HALL = np.array([8.0, 6.0, 1.5])
"""Half the size of the simulated hall [m]: from its centre, points are 1.5 to 10 m away."""

Cloud = tuple[NDArray[np.float32], NDArray[np.float32]]


def main() -> None:
    """Print the results as JSON, one line each."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--images", type=int, default=12)
    options = parser.parse_args()
    clouds = depth_clouds(options.folder, options.images) if options.folder else hall_clouds(options.images)
    for result in measure(clouds):
        print(json.dumps(result))  # noqa: T201 - the output of the bench


def measure(clouds: list[Cloud]) -> list[dict[str, Any]]:
    """Return the rates on one and two threads and of the yardstick, and the part of equal voxels."""
    yardstick = SetVolume(PARAMETERS.resolution, PARAMETERS.max_range, PARAMETERS.model())
    yardstick.insert(clouds[0][0][:1], clouds[0][1])
    yardstick = SetVolume(PARAMETERS.resolution, PARAMETERS.max_range, PARAMETERS.model())
    results = [{"method": "OctoMap's, on hash sets", **_rates(yardstick.insert, clouds)}]
    for threads in THREADS:
        VoxelVolume(PARAMETERS, lambda count=threads: count).insert(*clouds[0])  # type: ignore[misc]
        volume = VoxelVolume(PARAMETERS, lambda count=threads: count)  # type: ignore[misc]
        rates = _rates(volume.insert, clouds)
        results.append({"method": "blocks", "threads": threads, **rates, **_equality(yardstick, volume)})
    return results


def depth_clouds(folder: Path, most: int) -> list[Cloud]:
    """Return the clouds of depth images, evenly spread over the folder, and the positions of the camera."""
    from PIL import Image  # noqa: PLC0415 - of the extra bench

    matrix = np.loadtxt(folder / "camera-intrinsics.txt")
    files = sorted(folder.glob("*.depth.png"))
    clouds = []
    for file in files[:: max(1, len(files) // most)][:most]:
        image = np.asarray(Image.open(file)).astype(np.uint16)
        height, width = image.shape
        camera = PinholeCamera(width, height, matrix[0, 0], matrix[0, 2], matrix[1, 2])
        pose = np.loadtxt(file.with_name(file.name.replace("depth.png", "pose.txt")))
        points = points_of_depth(image, camera, pose, fy=matrix[1, 1])
        clouds.append((points, pose[:3, 3].astype(np.float32)))
    return clouds


def hall_clouds(count: int, points: int = 50_000) -> list[Cloud]:
    """Return scans of a laser with many rings that drives through a hall."""
    random = np.random.default_rng(1)
    clouds = []
    for place in np.linspace(-2.0, 2.0, count):
        turn, rise = random.uniform(-np.pi, np.pi, points), random.uniform(-0.4, 0.4, points)
        order = np.lexsort((turn, np.round(rise * 80.0)))
        rays = np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=1)[order]
        origin = np.array([place, 0.3, -0.2])
        ranges = ((np.sign(rays) * HALL - origin) / rays).min(axis=1) + random.normal(0.0, 0.01, points)
        clouds.append(((origin + rays * ranges[:, None]).astype(np.float32), origin.astype(np.float32)))
    return clouds


def _rates(insert: Callable[[NDArray[np.float32], NDArray[np.float32]], None], clouds: list[Cloud]) -> dict[str, Any]:
    begin, cpu = perf_counter(), process_time()
    for points, origin in clouds:
        insert(points, origin)
    wall, cpu = perf_counter() - begin, process_time() - cpu
    count = sum(len(points) for points, _ in clouds)
    return {
        "points": count,
        "points_per_s": round(count / wall),
        "points_per_cpu_s": round(count / cpu),
        "wall_s": round(wall, 3),
    }


def _equality(yardstick: SetVolume, volume: VoxelVolume) -> dict[str, float]:
    """Return the parts of voxels of the same log-odds, and of the same occupancy."""
    corners, log_odds = volume.blocks.corners, volume.blocks.log_odds
    slots, voxels = np.nonzero(~np.isnan(log_odds))
    keys = corners[slots] + np.stack([voxels % 8, voxels // 8 % 8, voxels // 64], axis=1)
    codes = code_of.py_func(*keys.T)
    wanted, theirs = yardstick.log_odds()
    _, first, second = np.intersect1d(codes, wanted, assume_unique=True, return_indices=True)
    ours, theirs = log_odds[slots, voxels][first], theirs[second]
    every = len(codes) + len(wanted) - len(first)
    return {
        "voxels": len(wanted),
        "equal_log_odds": float((ours == theirs).sum()) / every,
        "equal_occupancy": float(((ours >= 0.0) == (theirs >= 0.0)).sum()) / every,
    }


if __name__ == "__main__":
    main()

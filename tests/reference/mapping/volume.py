"""Slow, obvious twin of 3D mapping: OctoMap's insertion of point clouds and its octree, by sets and recursion."""

import math
import struct

import numpy as np
from numpy.typing import NDArray

Key = tuple[int, int, int]
MIDDLE = 32768


def key_of(point: NDArray[np.float32], resolution: float) -> Key | None:
    """Return the key of a point, None if it is beyond the range of keys (``coordToKeyChecked``)."""
    if not np.isfinite(point).all():
        return None
    key = tuple(math.floor(1.0 / resolution * float(value)) + MIDDLE for value in point)
    return key if all(0 <= k < 2 * MIDDLE for k in key) else None


def ray_keys(origin: NDArray[np.float32], end: NDArray[np.float32], resolution: float) -> list[Key]:
    """Return the voxels that a ray passes before its last one (``computeRayKeys``)."""
    first, last = key_of(origin, resolution), key_of(end, resolution)
    if first is None or last is None or first == last:
        return []
    keys, current = [first], list(first)
    direction = end - origin
    length = np.float32(math.sqrt(float(_square(direction))))
    direction = direction / length
    steps, reach, spacing = [0, 0, 0], [math.inf] * 3, [math.inf] * 3
    for i in range(3):
        if direction[i] != 0.0:
            steps[i] = 1 if direction[i] > 0.0 else -1
            border = (first[i] - MIDDLE + 0.5) * resolution + float(np.float32(steps[i] * resolution * 0.5))
            reach[i] = (border - float(origin[i])) / float(direction[i])
            spacing[i] = resolution / abs(float(direction[i]))
    while True:
        near = 0 if reach[0] < reach[1] else 1
        axis = near if reach[near] < reach[2] else 2
        current[axis] += steps[axis]
        reach[axis] += spacing[axis]
        if tuple(current) == last or min(reach) > length:
            return keys
        keys.append((current[0], current[1], current[2]))


class OctoMapVolume:
    """Log-odds of voxels by key."""

    def __init__(self, resolution: float, max_range: float, model: tuple[np.float32, ...]) -> None:
        self.resolution, self.max_range, self.model = resolution, max_range, model
        self.voxels: dict[Key, np.float32] = {}

    def insert(self, points: NDArray[np.float32], origin: NDArray[np.float32]) -> None:
        """Add a cloud (``OctomapServer::insertScan``: unlike in ``insertPointCloud``, the end of a cut ray is free)."""
        free: set[Key] = set()
        occupied: set[Key] = set()
        for point in points:
            away = point - origin
            distance = math.sqrt(float(_square(away)))
            if self.max_range < 0.0 or distance <= self.max_range:
                free.update(ray_keys(origin, point, self.resolution))
                key = key_of(point, self.resolution)
                if key is not None:
                    occupied.add(key)
            elif math.isfinite(distance):
                end = origin + away / np.float32(distance) * np.float32(self.max_range)
                free.update(ray_keys(origin, end, self.resolution))
                key = key_of(end, self.resolution)
                if key is not None:
                    free.add(key)
        hit, miss, least, most = self.model
        for keys, change in ((free - occupied, miss), (occupied, hit)):
            for key in keys:
                self.voxels[key] = min(max(self.voxels.get(key, np.float32(0.0)) + change, least), most)


def octree_body(voxels: dict[Key, float], kind: str) -> tuple[bytes, int]:
    """Return the nodes of voxels as ``bt`` or ``ot`` file, and their number."""
    if kind == "bt":
        voxels = {key: 1.0 if value >= 0.0 else -1.0 for key, value in voxels.items()}
    if not voxels:
        return b"", 0
    body, nodes, _ = _node(voxels, kind, 0, (0, 0, 0))
    return body, nodes


def _node(voxels: dict[Key, float], kind: str, depth: int, corner: Key) -> tuple[bytes, int, float]:
    half = 1 << (15 - depth)
    parts: dict[int, dict[Key, float]] = {}
    for key, value in voxels.items():
        child = sum((key[axis] >= corner[axis] + half) << axis for axis in range(3))
        parts.setdefault(child, {})[key] = value
    below, nodes, word, mask, values = b"", 1, 0, 0, []
    for child, part in sorted(parts.items()):
        mask |= 1 << child
        same = len(part) == half**3 and len(set(part.values())) == 1
        value = max(part.values())
        values.append(value)
        if same:
            word |= (2 if value >= 0.0 else 1) << 2 * child
            below += struct.pack("<fB", value, 0) if kind == "ot" else b""
            nodes += 1
        else:
            x, y, z = (corner[axis] + half * (child >> axis & 1) for axis in range(3))
            word |= 3 << 2 * child
            text, count, _ = _node(part, kind, depth + 1, (x, y, z))
            below += text
            nodes += count
    own = struct.pack("<H", word) if kind == "bt" else struct.pack("<fB", max(values), mask)
    return own + below, nodes, max(values)


def projected(voxels: dict[Key, float], low: float, high: float, resolution: float) -> dict[tuple[int, int], int]:
    """Return 100 or 0 for the columns of voxels that have an occupied voxel, or else a free one, between heights."""
    cells: dict[tuple[int, int], int] = {}
    for (x, y, z), value in voxels.items():
        bottom = (z - MIDDLE) * resolution
        if bottom + resolution > low and bottom < high:
            cells[x, y] = max(cells.get((x, y), 0), 100 if value >= 0.0 else 0)
    return cells


def _square(vector: NDArray[np.float32]) -> np.float32:
    x, y, z = vector
    return np.float32(x * x + y * y + z * z)


def moved_voxels(
    voxels: dict[Key, np.float32], motion: tuple[float, float, float], resolution: float
) -> dict[Key, np.float32]:
    """Return voxels turned by an angle about z and moved along x, y [m]: each has the value of where its centre was."""
    x, y, angle = motion
    c, s = math.cos(angle), math.sin(angle)
    around = ((key[2], q) for key in voxels for q in _around(key, c, s, x, y, resolution))
    places = {(math.floor(q[0]), math.floor(q[1]), layer) for layer, q in around}
    found = {}
    for key in places:
        dx, dy = (key[0] + 0.5 - MIDDLE) * resolution - x, (key[1] + 0.5 - MIDDLE) * resolution - y
        old = math.floor((c * dx + s * dy) / resolution) + MIDDLE, math.floor((c * dy - s * dx) / resolution) + MIDDLE
        if (*old, key[2]) in voxels:
            found[key] = voxels[(*old, key[2])]
    return found


def _around(key: Key, c: float, s: float, x: float, y: float, resolution: float) -> list[tuple[float, float]]:
    """Return the corners of the nine voxels around the new place of a voxel, as keys."""
    px, py = (key[0] + 0.5 - MIDDLE) * resolution, (key[1] + 0.5 - MIDDLE) * resolution
    qx, qy = (c * px - s * py + x) / resolution + MIDDLE, (s * px + c * py + y) / resolution + MIDDLE
    return [(qx + i, qy + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]

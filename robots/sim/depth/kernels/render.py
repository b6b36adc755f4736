"""Kernels: images of inverse depths of walls, floor, mirrors and solid shapes, and what a depth camera makes of them.

All kernels work in the camera's optical frame: x to the right, y down, z ahead. The ray of a pixel is (u, v, 1), so its
parameter is the depth, and the nearest surface is the one with the greatest inverse depth. Inverse depths are in 1/m;
0 stands for nothing.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Columns = NDArray[np.int16]
Marks = NDArray[np.uint8]

CLOSEST = 0.02
"""Depth below which shapes are cut off [m]."""


@njit(cache=True, nogil=True, error_model="numpy")
def background(
    u: Floats, v: Floats, up: Floats, eye: float, columns: Columns, ranges: Floats, height: float, inverse: Floats
) -> None:
    """Draw the floor and the walls.

    Parameters
    ----------
    u : (w,) array
        Slope of the rays of each column.
    v : (h,) array
        Slope of the rays of each row.
    up : (3,) array
        Unit vector that points up.
    eye : float
        Height of the camera above the floor [m].
    columns : (h, w) int16 array
        Index into ``ranges`` of the direction of each pixel.
    ranges : (n,) array
        Horizontal distance to the wall in each direction [m]; infinite without a wall.
    height : float
        Height of the walls [m].
    inverse : (h, w) array
        Inverse depths; overwritten.
    """
    for row in range(v.size):
        for column in range(u.size):
            a, b = u[column], v[row]
            rise = up[0] * a + up[1] * b + up[2]
            level = math.sqrt(max(a * a + b * b + 1.0 - rise * rise, 0.0))
            found = max(-rise / eye, 0.0)
            distance = ranges[columns[row, column]]
            # Height at which the ray meets the wall; a ray that meets the floor first is below 0 there.
            if distance < np.inf and eye * level + rise * distance <= height * level:
                found = max(found, level / max(distance, CLOSEST))
            inverse[row, column] = found


@njit(cache=True, nogil=True, error_model="numpy")
def mirrors(
    u: Floats,
    v: Floats,
    up: Floats,
    eye: float,
    columns: Columns,
    ranges: Floats,
    limits: Floats,
    inverse: Floats,
    mark: int,
    marks: Marks,
) -> None:
    """Draw one vertical mirror and mark its pixels.

    Parameters
    ----------
    u, v, up, eye, columns
        As in `background`.
    ranges : (n,) array
        Horizontal distance to the mirror in each direction [m]; infinite beside it.
    limits : (2,) array
        Heights of its lower and upper edge [m].
    inverse : (h, w) array
        Inverse depths; updated where the mirror is nearer.
    mark : int
        Number of this mirror, from 1.
    marks : (h, w) uint8 array
        Number of the mirror in each pixel; 0 for none.
    """
    for row in range(v.size):
        for column in range(u.size):
            distance = ranges[columns[row, column]]
            if distance < np.inf:
                a, b = u[column], v[row]
                rise = up[0] * a + up[1] * b + up[2]
                level = math.sqrt(max(a * a + b * b + 1.0 - rise * rise, 0.0))
                at = eye + rise * distance / level
                nearness = level / max(distance, CLOSEST)
                if limits[0] <= at <= limits[1] and nearness > inverse[row, column]:
                    inverse[row, column] = nearness
                    marks[row, column] = mark


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _span(low: float, high: float, near: float, far: float, slopes: Floats) -> tuple[int, int]:
    """Return the first pixel and the one after the last between two lateral bounds, for depths from near to far."""
    if near <= CLOSEST:
        return 0, slopes.size
    least = min(low / near, low / far)
    most = max(high / near, high / far)
    step = slopes[1] - slopes[0]
    first = math.floor(min(max((least - slopes[0]) / step, 0.0), float(slopes.size)))
    last = math.ceil(min(max((most - slopes[0]) / step, -1.0), float(slopes.size - 1)))
    return int(first), int(last) + 1


@njit(cache=True, nogil=True, error_model="numpy")
def draw_capsules(u: Floats, v: Floats, capsules: Floats, inverse: Floats) -> None:
    """Draw capsules: all points within a radius of a line segment.

    Parameters
    ----------
    u : (w,) array
        Slope of the rays of each column, evenly spaced.
    v : (h,) array
        Slope of the rays of each row, evenly spaced.
    capsules : (n, 7) array
        Both ends of the segment, and the radius [m]. A camera inside a capsule does not see it.
    inverse : (h, w) array
        Inverse depths; updated where a capsule is nearer.
    """
    for k in range(len(capsules)):
        ax, ay, az, bx, by, bz, radius = capsules[k]
        near, far = min(az, bz) - radius, max(az, bz) + radius
        if far <= CLOSEST:
            continue
        left, right = _span(min(ax, bx) - radius, max(ax, bx) + radius, near, far, u)
        top, bottom = _span(min(ay, by) - radius, max(ay, by) + radius, near, far, v)
        # The axis n from a to b; the ray starts at o = -a from the end a.
        nx, ny, nz = bx - ax, by - ay, bz - az
        nn = nx * nx + ny * ny + nz * nz
        no = -(nx * ax + ny * ay + nz * az)
        oo = ax * ax + ay * ay + az * az
        c_cylinder = nn * oo - no * no - radius * radius * nn
        c_a = oo - radius * radius
        c_b = bx * bx + by * by + bz * bz - radius * radius
        for row in range(top, bottom):
            for column in range(left, right):
                dx, dy = u[column], v[row]
                dd = dx * dx + dy * dy + 1.0
                nd = nx * dx + ny * dy + nz
                od = -(ax * dx + ay * dy + az)
                a = nn * dd - nd * nd
                b = nn * od - no * nd
                root = b * b - a * c_cylinder
                if root < 0.0 and nn > 1e-12:
                    continue
                depth, along = -1.0, -1.0
                if a > 1e-12:
                    depth = (-b - math.sqrt(max(root, 0.0))) / a
                    along = no + depth * nd
                if not 0.0 < along < nn:
                    # The ray passes the end of the cylinder: it can only hit one of the half spheres.
                    depth = -1.0
                    b_a = od
                    h_a = b_a * b_a - dd * c_a
                    if h_a >= 0.0:
                        depth = (-b_a - math.sqrt(h_a)) / dd
                    b_b = -(bx * dx + by * dy + bz)
                    h_b = b_b * b_b - dd * c_b
                    if h_b >= 0.0:
                        other = (-b_b - math.sqrt(h_b)) / dd
                        if depth <= CLOSEST or CLOSEST < other < depth:
                            depth = other
                if depth > CLOSEST and depth * inverse[row, column] < 1.0:
                    inverse[row, column] = 1.0 / depth


@njit(cache=True, nogil=True, error_model="numpy")
def draw_solids(u: Floats, v: Floats, solids: Floats, inverse: Floats) -> None:
    """Draw ellipsoids and boxes.

    Parameters
    ----------
    u : (w,) array
        Slope of the rays of each column, evenly spaced.
    v : (h,) array
        Slope of the rays of each row, evenly spaced.
    solids : (n, 16) array
        Columns: 1 for a box, 0 for an ellipsoid; centre [m]; the 3 × 3 matrix, row-major, that maps an offset from the
        centre into the unit sphere or the cube of half side 1; the half sizes of the bounding box along x, y and z [m].
        A camera inside a solid does not see it.
    inverse : (h, w) array
        Inverse depths; updated where a solid is nearer.
    """
    for k in range(len(solids)):
        solid = solids[k]
        cx, cy, cz = solid[1], solid[2], solid[3]
        near, far = cz - solid[15], cz + solid[15]
        if far <= CLOSEST:
            continue
        left, right = _span(cx - solid[13], cx + solid[13], near, far, u)
        top, bottom = _span(cy - solid[14], cy + solid[14], near, far, v)
        # Origin of the rays in the frame of the unit shape.
        ox = -(solid[4] * cx + solid[5] * cy + solid[6] * cz)
        oy = -(solid[7] * cx + solid[8] * cy + solid[9] * cz)
        oz = -(solid[10] * cx + solid[11] * cy + solid[12] * cz)
        for row in range(top, bottom):
            for column in range(left, right):
                a, b = u[column], v[row]
                dx = solid[4] * a + solid[5] * b + solid[6]
                dy = solid[7] * a + solid[8] * b + solid[9]
                dz = solid[10] * a + solid[11] * b + solid[12]
                ball = solid[0] == 0.0
                depth = _unit_sphere(ox, oy, oz, dx, dy, dz) if ball else _unit_cube(ox, oy, oz, dx, dy, dz)
                if depth > CLOSEST and depth * inverse[row, column] < 1.0:
                    inverse[row, column] = 1.0 / depth


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _unit_sphere(ox: float, oy: float, oz: float, dx: float, dy: float, dz: float) -> float:
    """Return the ray parameter at which a ray enters the unit sphere; -1 without a hit."""
    dd = dx * dx + dy * dy + dz * dz
    od = ox * dx + oy * dy + oz * dz
    root = od * od - dd * (ox * ox + oy * oy + oz * oz - 1.0)
    if root < 0.0:
        return -1.0
    return (-od - math.sqrt(root)) / dd


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _unit_cube(ox: float, oy: float, oz: float, dx: float, dy: float, dz: float) -> float:
    """Return the ray parameter at which a ray enters the cube of half side 1; -1 without a hit."""
    near, far = -np.inf, np.inf
    for o, d in ((ox, dx), (oy, dy), (oz, dz)):
        if abs(d) < 1e-12:
            if abs(o) > 1.0:
                return -1.0
        else:
            first, second = (-1.0 - o) / d, (1.0 - o) / d
            near = max(near, min(first, second))
            far = min(far, max(first, second))
    return near if near <= far else -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def measure(
    inverse: Floats,
    parallax: float,
    slack: float,
    noise: NDArray[np.float32],
    starts: NDArray[np.int64],
    scale: float,
    millimetres: NDArray[np.uint16],
    image: NDArray[np.uint16],
) -> None:
    """Turn inverse depths into a depth image: shadows of the projector, noise and quantization.

    The projector is to the right of the camera. A pixel is in shadow if the light to it passes behind a surface that
    the camera sees further right: seen from the projector, the columns of lit pixels keep their order.

    Parameters
    ----------
    inverse : (h, w) array
        Inverse depths [1/m].
    parallax : float
        Focal length times the distance of the projector [pixel m].
    slack : float
        Columns by which the order may be violated without a shadow [pixels].
    noise : (m + w,) float32 array
        Normal noise of the quantized inverse depth.
    starts : (h,) int64 array
        Start of each row's noise in ``noise``, below m.
    scale : float
        Steps of the inverse depth per 1/m.
    millimetres : (n,) uint16 array
        Depth of each step [mm]; 0 for those out of range.
    image : (h, w) uint16 array
        Depths [mm]; overwritten, 0 without a reading.
    """
    height, width = inverse.shape
    for row in range(height):
        leftmost = np.inf
        start = starts[row]
        for i in range(width):
            column = width - 1 - i
            nearness = inverse[row, column]
            lit = column - parallax * nearness
            depth = 0
            if lit <= leftmost + slack:
                leftmost = min(leftmost, lit)
                step = math.floor(nearness * scale + noise[start + column] + 0.5)
                if nearness > 0.0 and 0.0 <= step < millimetres.size:
                    depth = millimetres[int(step)]
            image[row, column] = depth


def warm() -> None:
    """Compile the kernels or load them from the cache."""
    slopes, up = np.array([-0.1, 0.1]), np.array([0.0, -1.0, 0.0])
    columns, inverse, marks = np.zeros((2, 2), np.int16), np.zeros((2, 2)), np.zeros((2, 2), np.uint8)
    background(slopes, slopes, up, 1.0, columns, np.ones(1), 2.5, inverse)
    mirrors(slopes, slopes, up, 1.0, columns, np.ones(1), np.array([0.0, 2.0]), inverse, 1, marks)
    draw_capsules(slopes, slopes, np.ones((1, 7)), inverse)
    draw_solids(slopes, slopes, np.ones((1, 16)), inverse)
    starts, image = np.zeros(2, np.int64), np.zeros((2, 2), np.uint16)
    measure(inverse, 43.0, 0.5, np.zeros(2, np.float32), starts, 350.0, np.zeros(9, np.uint16), image)

"""Recorded depth images, with the mount of the camera estimated from their surfaces."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.maps.formats.pictures import BROKEN
from ppaas.perception.depth_scan import PinholeCamera

Floats = NDArray[np.float64]

FOCAL, CENTRE = 585.0, (320.0, 240.0)
"""Focal length and principal point of the Kinect of 7-Scenes [pixels]."""

STEP = 8
"""Pixels between two points of a surface."""

LEVEL = np.radians(12.0)
"""Largest angle between the normals of level surfaces and the vertical [rad]."""

LOWEST = 1.0
"""Percentile of the heights of all points that is the floor."""


def recorded_images(folder: Path) -> Iterator[tuple[NDArray[np.uint16], PinholeCamera, Floats]]:
    """Yield the depth images of a folder [mm], each with its camera and its mount over the floor (4, 4).

    The folder has files ``NAME.depth.png`` and ``NAME.pose.txt`` as 7-Scenes does (Shotton et al., "Scene coordinate
    regression forests for camera relocalization in RGB-D images", CVPR 2013). The vertical is the direction of most
    normals above the horizon, since tables and floor are level; the floor is the lowest surface.

    Raises
    ------
    InvalidInput
        The folder has no such files, or one cannot be read.
    """
    files = sorted(folder.glob("*.depth.png"))
    if not files:
        raise InvalidInput(f"{folder} has no depth images NAME.depth.png; name the folder that has")
    images = [_image(file) for file in files]
    poses = [_pose(file.with_name(file.name.replace("depth.png", "pose.txt"))) for file in files]
    surfaces = [_surface(image, pose) for image, pose in zip(images, poses, strict=True)]
    points, normals = (np.concatenate(part) for part in zip(*surfaces, strict=True))
    up = _vertical(normals, np.mean([-pose[:3, 1] for pose in poses], axis=0))
    floor = float(np.percentile(points @ up, LOWEST))
    camera = PinholeCamera(images[0].shape[1], images[0].shape[0], FOCAL, *CENTRE)
    for image, pose in zip(images, poses, strict=True):
        yield image, camera, _mount(pose, up, floor)


def _image(file: Path) -> NDArray[np.uint16]:
    from PIL import Image  # noqa: PLC0415

    try:
        with Image.open(file) as image:
            return np.asarray(image).astype(np.uint16)
    except BROKEN as error:
        raise InvalidInput(f"{file} is not a depth image: {error}") from error


def _pose(file: Path) -> Floats:
    try:
        pose = np.loadtxt(file)
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{file} is not the pose of a camera: {error}") from error
    return pose


def _surface(image: NDArray[np.uint16], pose: Floats) -> tuple[Floats, Floats]:
    """Return points in the world and the normals of the surface there, towards the camera, (n, 3)."""
    depth = image[::STEP, ::STEP] / 1000.0
    depth[(depth == 0.0) | (depth > 5.0)] = np.nan
    v, u = np.indices(depth.shape) * STEP
    points = np.stack(((u - CENTRE[0]) / FOCAL * depth, (v - CENTRE[1]) / FOCAL * depth, depth), axis=2)
    right, down = points[:-1, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, :-1]
    normals = np.cross(down, right)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    known = np.isfinite(normals).all(axis=2)
    return points[:-1, :-1][known] @ pose[:3, :3].T + pose[:3, 3], normals[known] @ pose[:3, :3].T


def _vertical(normals: Floats, guess: Floats) -> Floats:
    """Return the mean of the normals around a first guess of the vertical, again around that mean."""
    up = guess / np.linalg.norm(guess)
    for angle in (*np.radians([50.0, 35.0, 25.0]), LEVEL, LEVEL, LEVEL):
        up = np.median(normals[normals @ up > np.cos(angle)], axis=0)
        up /= np.linalg.norm(up)
    return up


def _mount(pose: Floats, up: Floats, floor: float) -> Floats:
    """Return the transform from a camera to a frame on the floor below it that faces where the camera looks."""
    ahead = pose[:3, 2] - (pose[:3, 2] @ up) * up
    ahead /= np.linalg.norm(ahead)
    axes = np.stack((ahead, np.cross(up, ahead), up))
    mount = np.eye(4)
    mount[:3, :3] = axes @ pose[:3, :3]
    mount[2, 3] = pose[:3, 3] @ up - floor
    return mount

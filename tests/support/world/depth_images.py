"""Depth images of a simulated camera in an empty room."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.perception.depth_scan import PinholeCamera
from ppaas.perception.torso.floor_view import FloorView
from robots.sim.bodies.body import BodyModel, Stance, body_shapes
from robots.sim.depth.camera import DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.depth.shapes import Shapes, joined
from tests.support.world.rooms import room

GRID = room(12.0, 10.0)
HERE = Pose2D(2.0, 5.0, 0.0)
"""Pose of the robot; the wall ahead is 9.9 m away."""

SMALL = DepthCameraModel(320, 240)
"""Camera whose images are small."""


def image_of(*parts: Shapes, model: DepthCameraModel = SMALL, seed: int = 0) -> DepthImage:
    """Return the image of shapes in the robot's frame."""
    camera = DepthCamera(GRID.data >= 65, GRID.info, model, np.random.default_rng(seed))
    return camera.measure(HERE, Scene(joined([part.placed(HERE) for part in parts])))


def person(x: float, y: float, facing: float = np.pi, *, sitting: bool = False, height: float = 1.75) -> Shapes:
    """Return a person at a position in the robot's frame."""
    return body_shapes(BodyModel(height), Stance(sitting=sitting), Pose2D(x, y, facing))


def view_of(model: DepthCameraModel = SMALL, tilt: float = 0.0) -> FloorView:
    """Return the view of a camera, with an error of its mount: an angle by which it is said to look down [rad]."""
    (fx, fy), (cx, cy) = model.focal_lengths, model.centre
    mount = np.eye(4)
    down = DepthCameraModel(pitch=model.pitch + tilt).rotation
    mount[:3, :3], mount[:3, 3] = down.T, (model.x, model.y, model.z)
    return FloorView(PinholeCamera(model.width, model.height, fx, cx, cy), fy, mount)

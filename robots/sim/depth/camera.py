"""Simulated depth camera like the Kinect: it projects a pattern and triangulates it.

Noise and resolution are those that Khoshelham and Elberink measured ("Accuracy and Resolution of Kinect Depth Data for
Indoor Mapping Applications", Sensors 12, 2012): both grow with the square of the depth.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.sensor_msgs import CameraInfo, Image
from ppaas.messages.tf2_msgs import TFMessage
from robots.sim.depth.kernels import render as kernels
from robots.sim.depth.shapes import BOX, Mirror, Shapes, nothing, ranges_to, reflected_ranges

Floats = NDArray[np.float64]
DepthImage = NDArray[np.uint16]

DEPTH_FRAME, OPTICAL_FRAME = "camera_depth_frame", "camera_depth_optical_frame"
"""Frames of ROS's camera drivers: with x ahead, and with z ahead and x to the right."""

ERROR = 1.425e-3
"""Standard deviation of a depth z is ``ERROR`` z² [1/m]."""
RESOLUTION = 2.85e-3
"""Step between two depths around z is ``RESOLUTION`` z² [1/m]."""

NOISE_TABLE = 1 << 16
"""Number of random numbers that images take their noise from, each row from a random start."""


@dataclass(frozen=True)
class DepthCameraModel:
    """Parameters of a depth camera.

    Parameters
    ----------
    width, height : int
        Size of the images [pixels].
    field_of_view : tuple of float
        Horizontal and vertical field of view [rad].
    range_min, range_max : float
        Limits of the depth [m].
    error, resolution : float
        Standard deviation and step of a depth z, as multiples of z² [1/m]. The error includes the steps' error.
    baseline : float
        Distance of the projector to the right of the camera [m]; 0 for images without shadows.
    x, y, z : float
        Position of the camera in the robot's base frame, whose origin is on the floor [m].
    pitch : float
        Angle by which the camera looks down [rad].

    Raises
    ------
    InvalidParameter
        A value is out of range.
    """

    width: int = 640
    height: int = 480
    field_of_view: tuple[float, float] = (math.radians(57.0), math.radians(43.0))
    range_min: float = 0.45
    range_max: float = 8.0
    error: float = ERROR
    resolution: float = RESOLUTION
    baseline: float = 0.075
    x: float = 0.0
    y: float = 0.0
    z: float = 1.0
    pitch: float = 0.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not (2 <= self.width <= 4096 and 2 <= self.height <= 4096):
            raise InvalidParameter(f"images must have from 2×2 to 4096×4096 pixels, not {self.width}×{self.height}")
        if not all(0.0 < angle < math.radians(170.0) for angle in self.field_of_view):
            raise InvalidParameter("field_of_view must be two angles above 0° and below 170° [rad]")
        if not 0.0 < self.range_min < self.range_max <= 60.0:
            raise InvalidParameter("range_min must be above 0 and below range_max, which may be up to 60 m")
        if not (self.error >= 0.0 and self.resolution > 0.0 and self.baseline >= 0.0 and self.z > 0.0):
            raise InvalidParameter("error and baseline must not be negative; resolution and z must be above 0")
        if not abs(self.pitch) <= math.radians(60.0):
            raise InvalidParameter(f"pitch must be from -60° to 60°, not {math.degrees(self.pitch):g}°")

    @property
    def focal_lengths(self) -> tuple[float, float]:
        """Focal lengths fx and fy [pixels]."""
        across, down = self.field_of_view
        return 0.5 * self.width / math.tan(0.5 * across), 0.5 * self.height / math.tan(0.5 * down)

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point cx and cy [pixels]."""
        return 0.5 * (self.width - 1), 0.5 * (self.height - 1)

    @property
    def rotation(self) -> Floats:
        """(3, 3) matrix from the robot's base frame to the optical frame."""
        cosine, sine = math.cos(self.pitch), math.sin(self.pitch)
        return np.array(((0.0, -1.0, 0.0), (-sine, 0.0, -cosine), (cosine, 0.0, -sine)))

    @cached_property
    def slopes(self) -> tuple[Floats, Floats]:
        """Slopes of the rays of the columns and of the rows."""
        (fx, fy), (cx, cy) = self.focal_lengths, self.centre
        return (np.arange(self.width, dtype=np.float64) - cx) / fx, (np.arange(self.height, dtype=np.float64) - cy) / fy

    @cached_property
    def bearings(self) -> tuple[Floats, NDArray[np.int16]]:
        """Directions in which walls are measured, and the index of each pixel's.

        For a level camera they are the directions of its columns.

        Returns
        -------
        bearings : (n,) array
            From the robot's heading, counter-clockwise [rad].
        indices : (height, width) int16 array
        """
        u, v = self.slopes
        if self.pitch == 0.0:
            return -np.arctan(u), np.tile(np.arange(self.width, dtype=np.int16), (self.height, 1))
        ahead = math.cos(self.pitch) - math.sin(self.pitch) * v[:, None]
        pixels = np.arctan2(-u[None, :], ahead)
        bearings = np.linspace(pixels.min(), pixels.max(), 4 * self.width)
        step = bearings[1] - bearings[0]
        return bearings, np.rint((pixels - bearings[0]) / step).astype(np.int16)

    def transforms(self, base_frame: str) -> TFMessage:
        """Return the mount as transforms from the base frame to `DEPTH_FRAME` and on to `OPTICAL_FRAME`."""
        half = 0.5 * self.pitch
        turns = Quaternion(x=0.0, y=math.sin(half), z=0.0, w=math.cos(half)), Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5)
        places = Vector3(self.x, self.y, self.z), Vector3(0.0, 0.0, 0.0)
        names = (base_frame, DEPTH_FRAME), (DEPTH_FRAME, OPTICAL_FRAME)
        return TFMessage(
            transforms=[
                TransformStamped(Header(frame_id=parent), child, Transform(place, turn))
                for (parent, child), place, turn in zip(names, places, turns, strict=True)
            ]
        )


@dataclass(frozen=True, slots=True)
class Scene:
    """Surroundings of a camera beside the map, in the frame of the map.

    Parameters
    ----------
    shapes : Shapes
        Bodies, furniture and robots.
    mirrors : tuple of Mirror
    wall_height : float
        Height of all walls of the map [m].
    """

    shapes: Shapes = field(default_factory=nothing)
    mirrors: tuple[Mirror, ...] = ()
    wall_height: float = 2.5


class DepthCamera:
    """Depth camera of a robot.

    Parameters
    ----------
    occupied : (height, width) bool array
        Occupied cells of the map.
    info : GridInfo
        Resolution and origin of the map.
    model : DepthCameraModel
        Parameters.
    rng : numpy.random.Generator
        Random generator of the noise.
    """

    def __init__(
        self, occupied: NDArray[np.bool_], info: GridInfo, model: DepthCameraModel, rng: np.random.Generator
    ) -> None:
        self.model = model
        self._occupied = occupied
        self._info = info
        self._rng = rng
        self._inverse = np.empty((model.height, model.width))
        self._millimetres, self._noise = _steps(model), _noise(model, rng)

    def look_at(self, occupied: NDArray[np.bool_], info: GridInfo) -> None:
        """Measure another map from now on."""
        self._occupied, self._info = occupied, info

    def measure(self, pose: Pose2D, scene: Scene) -> DepthImage:
        """Return a depth image, (height, width) uint16 [mm]; 0 without a reading.

        Parameters
        ----------
        pose : Pose2D
            True pose of the robot in the map frame.
        scene : Scene
            Everything that the map does not contain.
        """
        model = self.model
        inverse = self.inverse_depths(pose, scene)
        image = np.empty((model.height, model.width), np.uint16)
        starts = self._rng.integers(NOISE_TABLE, size=model.height)
        parallax = model.focal_lengths[0] * model.baseline
        scale = 1.0 / model.resolution
        kernels.measure(inverse, parallax, 0.5, self._noise, starts, scale, self._millimetres, image)
        return image

    def inverse_depths(self, pose: Pose2D, scene: Scene) -> Floats:
        """Return the true inverse depths, (height, width) [1/m]; 0 where nothing is seen, reused by the next call."""
        model = self.model
        eye = pose @ Pose2D(model.x, model.y, 0.0)
        bearings, _ = model.bearings
        # Walls beyond the range still hide what is behind them; their depths are removed by the range of the camera.
        reach = 2.0 * model.range_max
        walls = cast_rays(self._occupied, self._info, eye, bearings, reach)
        self._background(walls, scene, self._inverse)
        marks = np.zeros((model.height, model.width), np.uint8) if scene.mirrors else None
        if marks is not None:
            self._mark(eye, scene, marks)
        mirrored = self._inverse.copy() if marks is not None else None
        self._draw(eye, scene.shapes, self._inverse)
        if marks is not None and mirrored is not None:
            # Something in front of a mirror hides it.
            marks[self._inverse != mirrored] = 0
            self._reflect(eye, scene, marks)
        return self._inverse

    def _background(self, ranges: Floats, scene: Scene, inverse: Floats) -> None:
        model = self.model
        u, v = model.slopes
        _, indices = model.bearings
        kernels.background(u, v, model.rotation[:, 2].copy(), model.z, indices, ranges, scene.wall_height, inverse)

    def _draw(self, eye: Pose2D, shapes: Shapes, inverse: Floats) -> None:
        u, v = self.model.slopes
        turn = self.model.rotation @ _from_map(eye.theta)
        seen = shapes.transformed(turn, -turn @ np.array((eye.x, eye.y, self.model.z)))
        kernels.draw_capsules(u, v, seen.capsules, inverse)
        kernels.draw_solids(u, v, _with_bounds(seen.solids), inverse)

    def _mark(self, eye: Pose2D, scene: Scene, marks: NDArray[np.uint8]) -> None:
        """Draw the mirrors, and mark their pixels."""
        model = self.model
        u, v = model.slopes
        bearings, indices = model.bearings
        up = model.rotation[:, 2].copy()
        for number, mirror in enumerate(scene.mirrors, 1):
            ranges = ranges_to(mirror, eye, bearings)
            limits = np.array((mirror.low, mirror.high))
            kernels.mirrors(u, v, up, model.z, indices, ranges, limits, self._inverse, number, marks)

    def _reflect(self, eye: Pose2D, scene: Scene, marks: NDArray[np.uint8]) -> None:
        """Replace the marked pixels by what the mirrors show: the scene reflected at the plane of the mirror."""
        bearings, indices = self.model.bearings
        for number, mirror in enumerate(scene.mirrors, 1):
            mine = marks == number
            if not mine.any():
                continue
            if not mirror.reflects:
                self._inverse[mine] = 0.0
                continue
            behind = np.full(self._inverse.shape, np.inf)
            used = np.zeros(len(bearings), bool)
            used[indices[mine]] = True
            ranges = reflected_ranges(
                mirror, eye, bearings, used, occupied=self._occupied, info=self._info, reach=2.0 * self.model.range_max
            )
            self._background(ranges, scene, behind)
            behind[~mine] = np.inf
            self._draw(eye, mirror.image(scene.shapes, eye), behind)
            self._inverse[mine] = behind[mine]

    def image(self, depths: DepthImage, stamp: float) -> Image:
        """Return depths as ``sensor_msgs/Image``, 16UC1 in mm."""
        height, width = depths.shape
        data = depths.astype("<u2", copy=False).tobytes()
        return Image(Header(stamp=Time.of(stamp), frame_id=OPTICAL_FRAME), height, width, "16UC1", 0, 2 * width, data)

    def info(self, stamp: float) -> CameraInfo:
        """Return the camera's ``sensor_msgs/CameraInfo``: a pinhole camera without distortion."""
        model = self.model
        (fx, fy), (cx, cy) = model.focal_lengths, model.centre
        return CameraInfo(
            header=Header(stamp=Time.of(stamp), frame_id=OPTICAL_FRAME),
            height=model.height,
            width=model.width,
            K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            distortion_model="plumb_bob",
            D=[0.0] * 5,
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        )


def _from_map(theta: float) -> Floats:
    """Return the (3, 3) matrix from the map frame to the frame of a robot with this heading."""
    cosine, sine = math.cos(theta), math.sin(theta)
    return np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))


def _with_bounds(solids: Floats) -> Floats:
    """Return solids with the half sizes of their bounding boxes appended."""
    axes = np.linalg.inv(solids[:, 4:].reshape(-1, 3, 3))
    boxes = solids[:, :1] == BOX
    halves = np.where(boxes, np.abs(axes).sum(axis=2), np.sqrt((axes**2).sum(axis=2)))
    return np.concatenate((solids, halves), axis=1)


def _steps(model: DepthCameraModel) -> NDArray[np.uint16]:
    """Return the depth of each step of the inverse depth [mm]; 0 for those out of range."""
    count = math.ceil(1.0 / (model.resolution * model.range_min)) + 2
    with np.errstate(divide="ignore"):
        depths = 1.0 / (model.resolution * np.arange(count))
    inside = (depths >= model.range_min) & (depths <= model.range_max)
    return np.where(inside, np.rint(1000.0 * np.where(inside, depths, 0.0)), 0.0).astype(np.uint16)


def _noise(model: DepthCameraModel, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return normal noise of the inverse depth, in steps, less the error that the steps add."""
    steps = model.error / model.resolution
    deviation = math.sqrt(max(steps * steps - 1.0 / 12.0, 0.0))
    return (deviation * rng.standard_normal(NOISE_TABLE + model.width)).astype(np.float32)

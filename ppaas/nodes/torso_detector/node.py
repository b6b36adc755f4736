"""Node ``torso_detector``: detects people in the depth images of a robot's camera."""

import math
from functools import partial
from typing import ClassVar

import msgspec
import numpy as np

from ppaas.decoding import from_json
from ppaas.errors import PPaaSError
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import SensorView
from ppaas.messages.people_msgs import PositionMeasurement, PositionMeasurementArray
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.depth_images import CameraInfoWait, DepthLens, depth_camera_of, depths_of
from ppaas.nodes.depthimage_to_laserscan.node import RATES
from ppaas.nodes.frames import BASE_FOOTPRINT, FrameListener, FrameNames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.octomap_server.job_queue import JobQueue
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.torso.detector import TorsoDetection, TorsoDetector
from ppaas.perception.torso.floor_view import FloorView
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from ppaas.transforms.spatial import Rigid, matrix_of

SLACK = 0.01
"""Jitter of a camera's images [s]; so much earlier than `max_rate` allows, an image is still used."""

CLOSE = 0.8
"""Distance from which a person is surely detected [m]: of one who is nearer, the image has neither head nor hips."""


class TorsoDetectorNode(Node):
    """Subscribes to depth images, ``camera_info`` and ``tf``; publishes the people in each image.

    Measurements have the stamp of their image, and are in the frame of the robot's body. An image without people gives
    an empty message. Images are processed in jobs, one after the other; if they come faster, the newest is used. Images
    before the first ``camera_info`` are ignored for a second, and refused after that.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : TorsoDetectorParameters
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "torso_detector"
    demands: ClassVar[Demands] = Demands(0.4, rates=RATES)
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.DEPTH_IMAGE, topics.COMPRESSED_DEPTH_IMAGE, topics.DEPTH_CAMERA_INFO, topics.TF, topics.TF_STATIC,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (topics.TORSO_MEASUREMENTS, topics.TORSO_VIEW)

    def __init__(self, context: Context, parameters: TorsoDetectorParameters, names: FrameNames | None = None) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._frames = FrameListener(names)
        self._wait = CameraInfoWait()
        self._camera: DepthLens | None = None
        self._detector: TorsoDetector | None = None
        self._jobs = JobQueue(context, most=1)
        self._built_for: tuple[DepthLens, Rigid] | None = None
        self._last = -math.inf
        self._error: PPaaSError | None = None

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle an image, a ``camera_info`` or transforms.

        Raises
        ------
        InvalidInput
            The image is malformed or does not match its ``camera_info``, or that is invalid or missing. For an image
            that is decoded in a job, the next image raises it.
        TransformError
            A transform is invalid, or the camera's is unknown.
        """
        if topic in (topics.TF.name, topics.TF_STATIC.name):
            self._frames.hear(topic, expect(message, TFMessage), self.context.elapsed(), self.context.now())
        elif topic == topics.DEPTH_CAMERA_INFO.name:
            self._camera = depth_camera_of(expect(message, CameraInfo))
        elif self._camera is None:
            self._wait.check(self.context.elapsed())
        else:
            compressed = topic == topics.COMPRESSED_DEPTH_IMAGE.name
            self._on_image(expect(message, CompressedImage) if compressed else expect(message, Image))

    def checkpoint(self) -> bytes | None:
        """Return the camera's parameters, which a robot may publish only once."""
        return msgspec.json.encode(self._camera) if self._camera is not None else None

    def restore(self, state: bytes) -> None:
        """Use the camera's parameters of a checkpoint."""
        self._camera = from_json(state, DepthLens)

    def _on_image(self, message: Image | CompressedImage) -> None:
        now = self.context.elapsed()
        if now - self._last < 1.0 / self._parameters.max_rate - SLACK:
            return
        self._last = now
        if self._error is not None:
            error, self._error = self._error, None
            raise error
        detector = self._detector_for(message.header.frame_id)
        read = partial(decompress, message.format, message.data) if isinstance(message, CompressedImage) else None
        depths = depths_of(message) if isinstance(message, Image) else np.empty((0, 0), np.uint16)
        self._jobs.add(
            lambda: detector.detect(read() if read is not None else depths),
            partial(self._finish, message.header), may_be_dropped=True,
        )  # fmt: skip

    def _detector_for(self, frame: str) -> TorsoDetector:
        """Return the detector for images of a frame; publish its view if it is a new one."""
        assert self._camera is not None
        mount = Rigid(z=-self._frames.height_of(BASE_FOOTPRINT)) @ self._frames.mount(frame)
        if self._detector is None or self._built_for != (self._camera, mount):
            view = FloorView(self._camera.lens, self._camera.fy, matrix_of(mount))
            self._detector = TorsoDetector(view, self._parameters)
            self._built_for = self._camera, mount
            self.context.publish(topics.TORSO_VIEW.name, view_of(self._detector, self._parameters))
        return self._detector

    def _finish(self, header: Header, result: list[TorsoDetection] | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            self._error = result
            return
        stamp = header.stamp if header.stamp != Time() else Time.of(self.context.now())
        header = Header(stamp=stamp, frame_id=self._frames.base)
        floor = self._frames.height_of(BASE_FOOTPRINT)
        people = [self._measurement(header, each, floor) for each in result]
        self.context.publish(topics.TORSO_MEASUREMENTS.name, PositionMeasurementArray(header, people))

    def _measurement(self, header: Header, found: TorsoDetection, floor: float) -> PositionMeasurement:
        return PositionMeasurement(
            header, self.name, "", Point(found.x, found.y, found.z + floor), found.score, found.covariance,
            int(found.score >= self._parameters.initialization_threshold),
        )  # fmt: skip


def view_of(detector: TorsoDetector, parameters: TorsoDetectorParameters) -> SensorView:
    """Return the region in which a detector detects all people, in the robot's frame."""
    (x, y), yaw, field = detector.position, detector.yaw, detector.field_of_view
    nearest = min(max(parameters.range_min, CLOSE), parameters.range_max)
    return SensorView(x, y, yaw, field, nearest, parameters.range_max)

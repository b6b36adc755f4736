"""Node ``depthimage_to_laserscan``: converts depth images to scans, for robots with a depth camera and no laser."""

from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, LaserScan
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.depth_images import CameraInfoWait, camera_of, depths_of
from ppaas.nodes.message_checks import expect
from ppaas.nodes.topics import COMPRESSED_DEPTH_IMAGE, DEPTH_CAMERA_INFO, DEPTH_IMAGE, SCAN
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.depth_scan import DepthScanner, DepthScanParameters, PinholeCamera
from ppaas.perception.kernels.depth import Depths

RATES = {DEPTH_IMAGE.name: 640 * 480 * 2 * 30 * 4 / 3, COMPRESSED_DEPTH_IMAGE.name: 0.0}
"""Data rate of a camera of 640 by 480 pixels with 16 bits at 30 Hz, as base64 in JSON [bytes/s]. The rate of compressed
images depends on the scene and is measured."""


class DepthImageToLaserScanNode(Node):
    """Subscribes to raw or compressed depth images and ``camera_info``; publishes ``scan``.

    The scan has the stamp of its image. Images before the first ``camera_info`` are ignored for a second, and refused
    after that.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : DepthScanParameters
        Named as in ROS's ``depthimage_to_laserscan``.
    """

    name: ClassVar[str] = "depthimage_to_laserscan"
    demands: ClassVar[Demands] = Demands(0.3, rates=RATES)
    subscribes: ClassVar[tuple[Topic, ...]] = (DEPTH_IMAGE, COMPRESSED_DEPTH_IMAGE, DEPTH_CAMERA_INFO)
    publishes: ClassVar[tuple[Topic, ...]] = (SCAN,)

    def __init__(self, context: Context, parameters: DepthScanParameters) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._scanner: DepthScanner | None = None
        self._wait = CameraInfoWait()

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle an image or a ``camera_info``.

        Raises
        ------
        InvalidInput
            The image is malformed or does not match its ``camera_info``, or that is invalid or missing.
        InvalidParameter
            The camera has fewer rows than the parameters require.
        """
        if topic == DEPTH_CAMERA_INFO.name:
            self._set_camera(camera_of(expect(message, CameraInfo)))
        elif self._scanner is None:
            self._wait.check(self.context.elapsed())
        elif topic == COMPRESSED_DEPTH_IMAGE.name:
            compressed = expect(message, CompressedImage)
            self._publish(self._scanner, compressed.header, decompress(compressed.format, compressed.data))
        else:
            image = expect(message, Image)
            self._publish(self._scanner, image.header, depths_of(image))

    def _set_camera(self, camera: PinholeCamera) -> None:
        if self._scanner is None or self._scanner.camera != camera:
            self._scanner = DepthScanner(camera, self._parameters)

    def checkpoint(self) -> bytes | None:
        """Return the camera's parameters, which a robot may publish only once."""
        return msgspec.json.encode(self._scanner.camera) if self._scanner is not None else None

    def restore(self, state: bytes) -> None:
        """Use the camera's parameters of a checkpoint."""
        self._set_camera(from_json(state, PinholeCamera))

    def _publish(self, scanner: DepthScanner, header: Header, image: Depths) -> None:
        own, ranges = self._parameters, scanner.scan(image).tolist()
        self.context.publish(
            SCAN.name,
            LaserScan(
                Header(stamp=header.stamp, frame_id=own.output_frame_id),
                scanner.angle_min, scanner.angle_max, scanner.angle_increment, own.range_min, own.range_max, ranges,
                scan_time=own.scan_time,
            ),
        )  # fmt: skip

"""Depth images and their ``camera_info``, as nodes receive them."""

import msgspec
import numpy as np

from ppaas.errors import InvalidInput
from ppaas.messages.sensor_msgs import CameraInfo, Image
from ppaas.nodes.topics import DEPTH_CAMERA_INFO
from ppaas.perception.depth_scan import PinholeCamera
from ppaas.perception.kernels.depth import Depths

PATIENCE = 1.0
"""Time for which images may come before the first ``camera_info`` [s]."""

_NUMBERS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}


class DepthLens(msgspec.Struct, frozen=True):
    """Depth camera: its lens, with the focal length along columns [pixels]."""

    lens: PinholeCamera
    fy: float


class CameraInfoWait:
    """Wait for the first ``camera_info``: images before it are ignored for `PATIENCE`, and refused after that."""

    def __init__(self) -> None:
        self._first_image: float | None = None

    def check(self, now: float) -> None:
        """Take note of an image that came before any ``camera_info``, at a time of the executor's clock [s].

        Raises
        ------
        InvalidInput
            The first such image came `PATIENCE` ago.
        """
        if self._first_image is None:
            self._first_image = now
        if now - self._first_image >= PATIENCE:
            raise InvalidInput(
                "depth images cannot be used before the first camera_info: publish sensor_msgs/CameraInfo on "
                f"{DEPTH_CAMERA_INFO.name!r}"
            )


def camera_of(info: CameraInfo) -> PinholeCamera:
    """Return the camera of a ``camera_info``.

    Raises
    ------
    InvalidInput
        It is not a camera's image.
    """
    if len(info.K) != 9:
        raise InvalidInput(f"camera_info.K must have 9 numbers, not {len(info.K)}")
    return PinholeCamera(info.width, info.height, info.K[0], info.K[2], info.K[5])


def depth_camera_of(info: CameraInfo) -> DepthLens:
    """Return the camera of a ``camera_info`` with its focal length along columns; raises as `camera_of`."""
    return DepthLens(camera_of(info), info.K[4])


def depths_of(image: Image) -> Depths:
    """Return the depths of an image (height, width), in mm as uint16 or in m as float32.

    Raises
    ------
    InvalidInput
        The encoding is not supported, or the image has fewer bytes than its size requires.
    """
    numbers = _NUMBERS.get(image.encoding)
    if numbers is None:
        raise InvalidInput(
            f"the encoding of a depth image must be one of {', '.join(_NUMBERS)}, not {image.encoding!r}"
        )
    kind = np.dtype((">" if image.is_bigendian else "<") + numbers)
    shape = image.height, image.width
    needed = image.step * (image.height - 1) + image.width * kind.itemsize
    if min(shape) < 1 or image.step < image.width * kind.itemsize or len(image.data) < needed:
        raise InvalidInput(
            f"an image of {image.width}×{image.height} {image.encoding} with {image.step} bytes per row cannot have "
            f"{len(image.data)} bytes of data"
        )
    depths = np.ndarray(shape, kind, image.data, strides=(image.step, kind.itemsize))
    return depths.astype(kind.newbyteorder("="), copy=False)

"""Depth images as PNG, in the format of ROS's ``compressed_depth_image_transport``: a fifth of their size or less.

An image in millimetres is kept as it is. Of one in metres the inverse is kept in 16 bits: near things are told more
finely than far ones, as depth cameras see them. Before the PNG stand twelve bytes that say how.
"""

import io
import struct

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.maps.formats.png import BROKEN
from ppaas.perception.depth_scan import MOST_PIXELS
from ppaas.perception.kernels.depth import Depths

FORMATS = {"uint16": "16UC1; compressedDepth png", "float32": "32FC1; compressedDepth png"}
"""What the messages call themselves, by the type of their numbers."""

QUANTIZATION = 100.0
MOST_DEPTH = 10.0
"""ROS's ``depth_quantization`` and ``depth_max`` [m]; what is farther is not known afterwards."""

_HEAD = struct.Struct("<iff")
_UNDEFINED, _INVERSE = 0, 1


def compress(image: Depths) -> tuple[str, bytes]:
    """Return the format and the data of a depth image.

    Parameters
    ----------
    image : (height, width) uint16 or float32 array
        mm or m; 0 or NaN where it is not known.
    """
    if image.dtype == np.uint16:
        return FORMATS["uint16"], _HEAD.pack(_UNDEFINED, 0.0, 0.0) + _png(image.astype(np.uint16, copy=False))
    scale = QUANTIZATION * (QUANTIZATION + 1.0)
    offset = 1.0 - scale / MOST_DEPTH
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = scale / image + offset
        known = (image > 0.0) & (image <= MOST_DEPTH) & (inverse <= np.iinfo(np.uint16).max)
    quantized = np.where(known, np.rint(np.where(known, inverse, 0.0)), 0).astype(np.uint16)
    return FORMATS["float32"], _HEAD.pack(_INVERSE, scale, offset) + _png(quantized)


def decompress(kind: str, data: bytes) -> Depths:
    """Return a depth image, (height, width): uint16 in mm, or float32 in m with NaN where it is not known.

    Parameters
    ----------
    kind : str
        What the message calls its format.
    data : bytes

    Raises
    ------
    InvalidInput
        Another format, a broken image, or one that is too large.
    """
    numbers = next((numbers for numbers, name in FORMATS.items() if kind.startswith(name)), None)
    if numbers is None or len(data) <= _HEAD.size:
        known = " or ".join(repr(name) for name in FORMATS.values())
        raise InvalidInput(f"a compressed depth image is {known}, not {kind!r} of {len(data)} bytes")
    _, scale, offset = _HEAD.unpack_from(data)
    pixels = _pixels(data[_HEAD.size :])
    if numbers == "uint16":
        return pixels
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.float32(scale) / (pixels.astype(np.float32) - np.float32(offset))
    return np.where(pixels == 0, np.float32(np.nan), depths)


def _png(pixels: NDArray[np.uint16]) -> bytes:
    from PIL.Image import fromarray  # noqa: PLC0415  # only who compresses needs Pillow

    file = io.BytesIO()
    fromarray(pixels).save(file, "png", compress_level=1)
    return file.getvalue()


def _pixels(data: bytes) -> NDArray[np.uint16]:
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415  # only who compresses needs Pillow

    try:
        image = PngImageFile(io.BytesIO(data))
        width, height = image.size
        if image.mode not in ("I;16", "L") or width * height > MOST_PIXELS:
            raise ValueError(f"{width}×{height} pixels of {image.mode}")
        return np.asarray(image).astype(np.uint16)
    except BROKEN as error:
        raise InvalidInput(f"a depth image is a grey PNG of 16 bits and cannot be read: {error}") from error

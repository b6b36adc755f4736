"""Compression of depth images as PNG, in the format of ROS's ``compressed_depth_image_transport``.

Images in millimetres are stored unchanged. Of images in metres, the inverse depth is quantized to 16 bits, which gives
near objects a finer resolution, as depth cameras do. A header of twelve bytes before the PNG has the parameters. The
result has a fifth of the original size or less.
"""

import io
import struct

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.formats.pillow_rows import BROKEN
from ppaas.maps.formats.png import check_chunks
from ppaas.perception.depth_scan import MOST_PIXELS
from ppaas.perception.kernels.depth import Depths

FORMATS = {"uint16": "16UC1; compressedDepth png", "float32": "32FC1; compressedDepth png"}
"""Format of a message by the type of the image's numbers."""

QUANTIZATION = 100.0
MOST_DEPTH = 10.0
"""Defaults of ROS's ``depth_quantization`` and ``depth_max`` [m]; larger depths are lost."""

_HEAD = struct.Struct("<iff")
_UNDEFINED, _INVERSE = 0, 1


def compress(image: Depths) -> tuple[str, bytes]:
    """Return the format and the data of a depth image.

    Parameters
    ----------
    image : (height, width) uint16 or float32 array
        Depths in mm or m, respectively; 0 or NaN where unknown.
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
    """Return a depth image, (height, width): uint16 in mm, or float32 in m with NaN where unknown.

    Parameters
    ----------
    kind : str
        Format of the message.
    data : bytes
        Data of the message.

    Raises
    ------
    InvalidInput
        The format is unknown, or the image is broken or too large.
    """
    numbers = next((numbers for numbers, name in FORMATS.items() if kind.startswith(name)), None)
    if numbers is None or len(data) <= _HEAD.size:
        known = " or ".join(repr(name) for name in FORMATS.values())
        raise InvalidInput(f"the format of a compressed depth image must be {known}, not {kind!r} of {len(data)} bytes")
    _, scale, offset = _HEAD.unpack_from(data)
    pixels = _pixels(data[_HEAD.size :])
    if numbers == "uint16":
        return pixels
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.float32(scale) / (pixels.astype(np.float32) - np.float32(offset))
    return np.where(pixels == 0, np.float32(np.nan), depths)


def _png(pixels: NDArray[np.uint16]) -> bytes:
    from PIL.Image import fromarray  # noqa: PLC0415  # Pillow is needed only for compressed images

    file = io.BytesIO()
    fromarray(pixels).save(file, "png", compress_level=1)
    return file.getvalue()


def _pixels(data: bytes) -> NDArray[np.uint16]:
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415  # Pillow is needed only for compressed images

    try:
        check_chunks(data)
        image = PngImageFile(io.BytesIO(data))
        width, height = image.size
        if image.mode not in ("I;16", "L") or width * height > MOST_PIXELS:
            raise ValueError(f"it has {width}×{height} pixels of mode {image.mode}")
        return np.asarray(image).astype(np.uint16)
    except (*BROKEN, InvalidMap) as error:
        raise InvalidInput(f"the depth image cannot be read as a grey PNG of 16 bits: {error}") from error

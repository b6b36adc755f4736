"""Compression of depth images as PNG or RVL, in the formats of ROS's ``compressed_depth_image_transport``.

Images in millimetres are stored unchanged. Of images in metres, the inverse depth is quantized to 16 bits, which gives
near objects a finer resolution, as depth cameras do. A header of twelve bytes has the parameters; the PNG follows,
or width, height and the code of RVL. A PNG has a fifth of the original size or less.
"""

import io
import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.formats.pictures import BROKEN, check_chunks
from ppaas.maps.formats.pictures import MAGIC as PNG_MAGIC
from ppaas.perception.depth_scan import MOST_PIXELS
from ppaas.perception.kernels.depth import Depths
from ppaas.perception.kernels.rvl import expand_rvl

FORMATS = {"uint16": "16UC1; compressedDepth png", "float32": "32FC1; compressedDepth png"}
"""Format of a message by the type of the image's numbers."""

_ENCODINGS = ("16UC1", "mono16", "32FC1")
"""Encodings of depth images."""

QUANTIZATION = 100.0
MOST_DEPTH = 10.0
"""Defaults of ROS's ``depth_quantization`` and ``depth_max`` [m]; larger depths are lost."""

_HEAD, _SIZE = struct.Struct("<iff"), struct.Struct("<II")
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
    encoding, codec = _format_of(kind)
    if codec is None or len(data) <= _HEAD.size:
        raise InvalidInput(
            "the format of a compressed depth image must be '16UC1; compressedDepth png' or '32FC1; compressedDepth "
            f"png', or one of them with rvl, not {kind[:64]!r} of {len(data)} bytes"
        )
    if data.startswith(PNG_MAGIC):  # as the transport ``compressed`` writes it, without a header
        if encoding == "32FC1":
            raise InvalidInput("a depth image in metres needs the header of compressedDepth before its PNG")
        return _png_pixels(data)
    _, scale, offset = _HEAD.unpack_from(data)
    pixels = codec(data[_HEAD.size :])
    if encoding != "32FC1":
        return pixels
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.float32(scale) / (pixels.astype(np.float32) - np.float32(offset))
    return np.where(pixels == 0, np.float32(np.nan), depths)


def _format_of(kind: str) -> tuple[str, Callable[[bytes], NDArray[np.uint16]] | None]:
    """Return the encoding in a format, and the decoder of its codec; None if one of them is unknown.

    A format that names no codec is of early versions, which knew PNG alone (``codec.cpp`` of the transport). The
    transport ``compressed`` writes ``16UC1; png compressed``.
    """
    encoding, _, rest = (part.strip() for part in kind.partition(";"))
    if encoding in _ENCODINGS and rest.startswith("png compressed"):
        return encoding, _png_pixels
    transport, _, codec = rest.partition(" ")
    known = encoding in _ENCODINGS and transport in ("", "compressedDepth")
    return encoding, _CODECS.get(codec.strip()) if known else None


def _png(pixels: NDArray[np.uint16]) -> bytes:
    from PIL.Image import fromarray  # noqa: PLC0415  # Pillow is needed only for compressed images

    file = io.BytesIO()
    fromarray(pixels).save(file, "png", compress_level=1)
    return file.getvalue()


def _rvl_pixels(data: bytes) -> NDArray[np.uint16]:
    width, height = _SIZE.unpack_from(data) if len(data) >= _SIZE.size else (0, 0)
    if not 0 < width * height <= MOST_PIXELS:
        raise InvalidInput(f"the depth image cannot be read as RVL: it has {width}×{height} pixels")
    words = np.frombuffer(data, "<u4", (len(data) - _SIZE.size) // 4, _SIZE.size)
    pixels = np.empty(width * height, np.uint16)
    found = expand_rvl(words, pixels)
    if found < len(pixels):
        raise InvalidInput(f"the depth image cannot be read as RVL: it ends after {found} of {len(pixels)} pixels")
    return pixels.reshape(height, width)


def _png_pixels(data: bytes) -> NDArray[np.uint16]:
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


_CODECS = {"": _png_pixels, "png": _png_pixels, "rvl": _rvl_pixels}
"""Decoders by the names of codecs."""

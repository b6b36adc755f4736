"""Messages as PNG for subscriptions with ``compression: png``, as ``rosbridge_suite`` sends them.

The text of a frame becomes the bytes of an RGB image that is nearly square, padded with line feeds, which comes in
base64 in the operation ``png``.

Source: ``rosbridge_library/internal/pngcompression.py`` of ``RobotWebTools/rosbridge_suite``.
"""

import base64
import io
import json
import math
import re
from typing import Final

_NOT_ASCII: Final = re.compile(r"[^\x00-\x7f]")

_PIXEL: Final = 3
"""Size of a pixel [bytes]."""

_LEVEL: Final = 3
"""Level of zlib: 6 takes three times as long for messages that are a sixth smaller."""


def png_frame(frame: bytes) -> bytes:
    """Return the frame of ``png`` that contains a frame, which is JSON."""
    from PIL.Image import frombytes  # noqa: PLC0415  # Pillow is needed only for clients of PNG

    text = _ascii(frame)
    width = max(math.isqrt(len(text) // _PIXEL), 1)
    height = max(-(-len(text) // (_PIXEL * width)), 1)
    file = io.BytesIO()
    image = frombytes("RGB", (width, height), text.ljust(width * height * _PIXEL, b"\n"))
    image.save(file, "png", compress_level=_LEVEL)
    return b'{"op":"png","data":"%b"}' % base64.b64encode(file.getvalue())


def _ascii(frame: bytes) -> bytes:
    """Return a frame with other characters escaped: web pages read each byte of the image as a character."""
    if frame.isascii():
        return frame
    return _NOT_ASCII.sub(lambda character: json.dumps(character[0])[1:-1], frame.decode()).encode()

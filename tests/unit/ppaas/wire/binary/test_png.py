"""Messages as PNG."""

import base64
import io
import json

from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from ppaas.wire.binary.packing import png_frame


def text_in(frame: bytes) -> str:
    """Return the text in a frame of ``png`` as web pages read it: each byte of a pixel is a character."""
    operation = json.loads(frame)
    assert operation["op"] == "png"
    image = Image.open(io.BytesIO(base64.b64decode(operation["data"])))
    assert image.mode == "RGB"
    return image.tobytes().decode("latin-1")


@given(st.dictionaries(st.text(), st.text()))
def test_a_frame_comes_back_from_the_pixels(message: dict[str, str]) -> None:
    frame = json.dumps(message, ensure_ascii=False).encode()
    assert json.loads(text_in(png_frame(frame))) == message


def test_an_image_is_nearly_square_and_padded_with_line_feeds() -> None:
    frame = json.dumps({"a": "x" * 1000}).encode()
    image = Image.open(io.BytesIO(base64.b64decode(json.loads(png_frame(frame))["data"])))
    assert (image.width, image.height) == (18, 19)
    assert text_in(png_frame(frame)) == frame.decode().ljust(18 * 19 * 3, "\n")


def test_a_map_becomes_smaller() -> None:
    frame = json.dumps({"data": [0, 100, -1] * 5000}).encode()
    assert len(png_frame(frame)) < len(frame) / 20

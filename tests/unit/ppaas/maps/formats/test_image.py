"""Images of maps: the first bytes decide the format, whatever the name of the file is.

The kind, and its members: what SDL_image reads for map_server and GraphicsMagick for Nav2, as far as programs write
maps so: PGM, PPM and PBM (binary and text), PNG, BMP, JPEG, TIFF. Compressed TIFF, GIF, WebP, TGA, PCX and XPM are
refused with advice: their decoders bring more faults than maps.
"""

import io

import numpy as np
import pytest
from PIL import Image
from PIL.ImageFile import ImageFile

from ppaas.errors import InvalidMap
from ppaas.maps.formats.image import ENDINGS, FORMATS, format_of, image_size, media_type, open_image
from tests.support.world.png import RGBA, png

GREYS = np.array([[0, 255]], np.uint8)


def written(name: str) -> bytes:
    file = io.BytesIO()
    Image.fromarray(GREYS).save(file, name)
    return file.getvalue()


FILES = {
    "PGM": [b"P5 2 1 255 \x00\xff", b"P2 2 1 255 0 255", b"P5\r\n2 1\r\n255\r\n\x00\xff"],
    "PNG": [png([b"\x00\xff"], 2)],
    "PPM": [b"P6 2 1 255 \x00\x00\x00\xff\xff\xff", b"P3 2 1 1 0 0 0 1 1 1"],
    "PBM": [b"P4 2 1 \x80", b"P1 2 1 10"],
    "BMP": [written("BMP")],
    "JPEG": [written("JPEG")],
    "TIFF": [written("TIFF")],
}


@pytest.mark.parametrize(("name", "image"), [(name, image) for name, images in FILES.items() for image in images])
def test_image_format_is_detected_by_the_first_bytes(name, image):
    opened = open_image(image)
    opened.check()
    assert opened.shape == (1, 2)
    read = opened.rows(0, 1)
    assert np.abs(read.channels.astype(int) - GREYS[..., np.newaxis]).max() <= (20 if name == "JPEG" else 0)
    assert read.alpha is None
    assert format_of(image).name == name
    assert media_type(image) == format_of(image).media_type


@pytest.mark.parametrize("image", [image for images in FILES.values() for image in images])
def test_the_size_of_an_image_is_read_from_its_header_alone(image, monkeypatch):
    monkeypatch.setattr(ImageFile, "load", None)
    assert image_size(image) == (1, 2)
    if len(image) < 20:  # a header of netpbm, which the pixels follow
        assert image_size(image[:-1]) == (1, 2)


def test_every_format_is_tested_and_has_endings_of_its_own():
    assert list(FILES) == [one.name for one in FORMATS]
    assert len(set(ENDINGS)) == len(ENDINGS)
    assert len({one.media_type for one in FORMATS}) == len(FORMATS)


def test_alpha_is_the_fourth_channel():
    alpha = open_image(png([b"\x01\x02\x03\x04"], 1, colour=RGBA)).rows(0, 1).alpha
    assert alpha is not None
    assert alpha.tolist() == [[4]]


@pytest.mark.parametrize("image", [b"", b"GIF89a", b"RIFF\x10\0\0\0WEBPVP8 ", b"P7\nWIDTH 1\n", b"image: a.pgm\n"])
def test_unknown_format_is_refused_with_the_supported_ones(image):
    with pytest.raises(InvalidMap, match=r"none of the formats PGM, PNG, .*: convert it to one of them"):
        open_image(image)

import pytest

from ppaas.errors import InvalidMap
from ppaas.maps.formats.image import media_type, open_image
from tests.support.world.png import RGBA, png

PGM, TEXT, PNG = b"P5 2 1 255 \x00\xfe", b"P2 2 1 255 0 254", png([b"\x00\xfe"], 2)


@pytest.mark.parametrize("image", [PGM, TEXT, PNG])
def test_image_format_is_detected_by_the_first_bytes(image):
    read = open_image(image).rows(0, 1)
    assert read.channels.tolist() == [[[0], [254]]]
    assert read.alpha is None


def test_alpha_is_the_fourth_channel():
    alpha = open_image(png([b"\x01\x02\x03\x04"], 1, colour=RGBA)).rows(0, 1).alpha
    assert alpha is not None
    assert alpha.tolist() == [[4]]


@pytest.mark.parametrize("image", [b"", b"GIF89a", b"\xff\xd8\xff\xe0 JFIF", b"P6 1 1 255 abc", b"image: a.pgm\n"])
def test_unknown_format_is_refused_with_the_supported_ones(image):
    with pytest.raises(InvalidMap, match=r"neither PGM \(P2, P5\) nor PNG"):
        open_image(image)


def test_media_type_is_detected_from_the_bytes():
    assert [media_type(image) for image in (PGM, TEXT, PNG)] == ["image/x-portable-graymap"] * 2 + ["image/png"]

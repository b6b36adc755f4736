"""Images of drawing programs: BMP, JPEG, and TIFF without compression."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from ppaas.errors import InvalidMap
from ppaas.maps.formats import pictures
from ppaas.maps.formats.pictures import open_picture

GREYS = np.array([[0, 205, 254], [255, 90, 0]], np.uint8)


def written(name: str, mode: str, **options: object) -> bytes:
    """Return a file of the greys in one of Pillow's modes."""
    file = io.BytesIO()
    image = Image.fromarray(GREYS)
    if mode == "I;16":
        image = Image.fromarray(GREYS.astype(np.uint16) << 8 | 0x7F)
    elif mode == "P":
        image = image.convert("RGB").quantize(8)
    elif mode != "L":
        image = image.convert("RGB").convert(mode)
    image.save(file, name, **options)
    return file.getvalue()


def parse(image, name):
    opened = open_picture(image, name)
    assert opened.shape == (2, 3)
    return opened.rows(0, 2)


@pytest.mark.parametrize(
    ("name", "mode"),
    [("BMP", "L"), ("BMP", "P"), ("BMP", "RGB"), ("TIFF", "L"), ("TIFF", "P"), ("TIFF", "RGB"), ("TIFF", "I;16")],
)
def test_opaque_images_of_every_depth_are_read_exactly(name, mode):
    read = parse(written(name, mode), name)
    assert read.dtype == np.uint8
    assert read.shape[2] in (1, 3)
    assert np.array_equal(read, np.repeat(GREYS[..., np.newaxis], read.shape[2], axis=2))


@pytest.mark.parametrize("name", ["BMP", "TIFF"])
def test_images_of_bits_are_black_and_white(name):
    image = Image.fromarray(GREYS > 100)
    file = io.BytesIO()
    image.save(file, name)
    assert parse(file.getvalue(), name)[..., 0].tolist() == np.where(GREYS > 100, 255, 0).tolist()


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_alpha_of_a_tiff_is_kept(mode):
    read = parse(written("TIFF", mode), "TIFF")
    assert np.array_equal(read[..., 0], GREYS)
    assert (read[..., 3] == 255).all()


@pytest.mark.parametrize("mode", ["L", "RGB", "CMYK"])
@pytest.mark.parametrize("progressive", [False, True])
def test_a_jpeg_is_read_but_for_its_losses(mode, progressive):
    read = parse(written("JPEG", mode, quality=100, subsampling=0, progressive=progressive), "JPEG")
    assert np.abs(read.mean(axis=2) - GREYS).max() < 8


@pytest.mark.parametrize("compression", ["tiff_lzw", "tiff_adobe_deflate", "packbits", "jpeg"])
def test_a_compressed_tiff_is_refused_with_advice(compression):
    with pytest.raises(InvalidMap, match="TIFF is compressed: save the map's image without compression, or as PNG"):
        parse(written("TIFF", "L", compression=compression), "TIFF")


@pytest.mark.parametrize("orientation", [1, 2, 3, 6, 8])
def test_a_tiff_that_viewers_turn_is_refused(orientation):
    data = written("TIFF", "L", tiffinfo={274: orientation})
    if orientation == 1:
        assert np.array_equal(parse(data, "TIFF")[..., 0], GREYS)
        return
    with pytest.raises(
        InvalidMap, match=rf"the TIFF is turned \(orientation {orientation}\): save the map's image upright"
    ):
        parse(data, "TIFF")


@pytest.mark.parametrize("orientation", [0, 1, 3, 6, 8])
def test_a_jpeg_that_viewers_turn_by_its_exif_is_refused(orientation):
    exif = Image.Exif()
    exif[274] = orientation
    data = written("JPEG", "L", exif=exif)
    if orientation < 2:
        assert parse(data, "JPEG").shape[:2] == GREYS.shape
        return
    with pytest.raises(InvalidMap, match=rf"the JPEG is turned \(orientation {orientation}\)"):
        parse(data, "JPEG")


def test_samples_of_32_bits_are_refused():
    file = io.BytesIO()
    Image.fromarray(GREYS.astype(np.float32)).save(file, "TIFF")
    with pytest.raises(InvalidMap, match="32 bits per sample"):
        parse(file.getvalue(), "TIFF")


def test_a_jpeg_of_many_scans_is_refused_before_decoding(monkeypatch):
    monkeypatch.setattr(pictures, "MAX_SCANS", 2)
    with pytest.raises(InvalidMap, match="more than 2 scans"):
        parse(written("JPEG", "RGB", progressive=True), "JPEG")


@pytest.mark.parametrize("name", ["BMP", "JPEG", "TIFF"])
def test_the_size_is_checked_before_decoding(name, monkeypatch):
    monkeypatch.setattr(pictures, "MAX_PIXELS", 5)
    with pytest.raises(InvalidMap, match=rf"the {name} has 3×2 pixels; a map's {name} must have from 1 to 5 pixels"):
        parse(written(name, "L"), name)


@pytest.mark.parametrize("name", ["BMP", "JPEG", "TIFF"])
@given(rubbish=st.binary(max_size=60), place=st.integers(0, 2000))
def test_broken_images_are_read_or_raise_invalid_map(name, rubbish, place):
    good = written(name, "RGB")
    place %= len(good)
    for image in (good[:4] + rubbish, good[:place], good[:place] + rubbish + good[place + len(rubbish) :]):
        try:
            opened = open_picture(image, name)
            assert opened.rows(0, min(9, opened.shape[0])).dtype == np.uint8
        except InvalidMap as error:
            assert str(error)

"""Images that Pillow decodes, good and bad: PNG of every kind, BMP, JPEG, and TIFF without compression."""

import io
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from ppaas.errors import InvalidMap
from ppaas.maps.formats import pictures
from ppaas.maps.formats.pictures import MAX_CHUNKS, MAX_OTHERS, MAX_PIXELS, open_picture, open_png, png_size
from tests.support.world.maps import sides
from tests.support.world.png import GREY_ALPHA, PALETTE, RGB, RGBA, SIGNATURE, chunk, header, png

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


def parse_png(image):
    opened = open_png(image)
    return opened.rows(0, opened.shape[0])


GOOD = png([b"\x00\xfe"], 2)


def grey(*values: int) -> list[list[int]]:
    return [[value] for value in values]


@pytest.mark.parametrize(
    ("image", "pixels"),
    [
        (png([b"\x00\xcd\xfe"], 3), [grey(0, 205, 254)]),
        (png([b"\x01", b"\x02"], 1), [grey(1), grey(2)]),
        (png([b"\xa0"], 3, depth=1), [grey(255, 0, 255)]),
        (png([b"\x1b"], 4, depth=2), [grey(0, 85, 170, 255)]),
        (png([b"\x0f"], 2, depth=4), [grey(0, 255)]),
        (png([b"\x00\xff\x12\x34\xff\x00"], 3, depth=16), [grey(0, 0x12, 255)]),
        (png([b"\x07\x80\x09\x00"], 2, colour=GREY_ALPHA), [[[7, 7, 7, 128], [9, 9, 9, 0]]]),
        (png([b"\x07\xff\x80\x01"], 1, 16, GREY_ALPHA), [[[7, 7, 7, 128]]]),
        (png([b"\x01\x02\x03\xff\xfe\xfd"], 2, colour=RGB), [[[1, 2, 3], [255, 254, 253]]]),
        (png([b"\x01\xff\x02\xff\x03\xff"], 1, 16, RGB), [[[1, 2, 3]]]),
        (png([b"\x01\x02\x03\x04"], 1, colour=RGBA), [[[1, 2, 3, 4]]]),
        (png([b"\x01\x00\x02\x00\x03\x00\x04\x00"], 1, 16, RGBA), [[[1, 2, 3, 4]]]),
        (png([b"\x01\x00"], 2, 8, PALETTE, chunk(b"PLTE", bytes(range(6)))), [[[3, 4, 5], [0, 1, 2]]]),
        (
            png([b"\x01\x00"], 2, 8, PALETTE, chunk(b"PLTE", bytes(range(6))) + chunk(b"tRNS", b"\x09")),
            [[[3, 4, 5, 255], [0, 1, 2, 9]]],
        ),
        (png([b"\x07\x08"], 2, before=chunk(b"tRNS", b"\0\x07")), [[[7, 7, 7, 0], [8, 8, 8, 255]]]),
        (png([b"\x12\x34\x12\x35"], 2, 16, before=chunk(b"tRNS", b"\x12\x34")), [[[18] * 3 + [0], [18] * 3 + [255]]]),
        (png([b"\x80"], 2, 1, before=chunk(b"tRNS", b"\0\x01")), [[[255] * 3 + [0], [0] * 3 + [255]]]),
        (
            png([b"\x01\x02\x03\x01\x02\x04"], 2, colour=RGB, before=chunk(b"tRNS", b"\0\x01\0\x02\0\x03")),
            [[[1, 2, 3, 0], [1, 2, 4, 255]]],
        ),
    ],
)
def test_every_colour_type_and_depth_is_read_at_eight_bits(image, pixels):
    assert parse_png(image).tolist() == pixels


@pytest.mark.parametrize(
    "image",
    [
        png([b"\x00\xff\x12", b"\x00\x01\x02"], 3),
        png([b"\x12\x34", b"\x12\x35"], 1, 16, before=chunk(b"tRNS", b"\x12\x34")),
        png([b"\x01\x00", b"\x00\x00"], 2, 8, PALETTE, chunk(b"PLTE", bytes(range(6))) + chunk(b"tRNS", b"\x09")),
    ],
)
def test_single_rows_equal_rows_of_the_whole_image(image):
    opened = open_png(image)
    assert opened.shape[0] == 2
    assert np.array_equal(np.concatenate([opened.rows(0, 1), opened.rows(1, 2)]), parse_png(image))


@given(hnp.arrays(np.uint8, sides(20)), st.booleans())
def test_images_written_by_pillow_are_read(pixels, grey_alpha):
    written = io.BytesIO()
    Image.fromarray(pixels).convert("LA" if grey_alpha else "L").save(written, "PNG", optimize=True)
    assert np.array_equal(parse_png(written.getvalue())[..., 0], pixels)


@pytest.mark.parametrize(
    "image",
    [
        SIGNATURE,
        GOOD[:30],
        GOOD[:-20],
        GOOD[:-9],
        GOOD.replace(b"IDAT", b"IDAX"),
        GOOD.replace(b"IDAT", b"iDAt"),
        header(2, 2) + chunk(b"IEND"),
        header(2, 2) + chunk(b"IDAT", b"no deflate") + chunk(b"IEND"),
        png([b"\x00\xfe"], 2, depth=3),
        png([b"\x00\xfe"], 2, colour=5),
        png([b"\x00"], 2),
        png([b"\x05"], 1, colour=PALETTE),
    ],
)
def test_corrupt_image_is_refused(image):
    with pytest.raises(InvalidMap, match=r"cannot be read.*save the map's image again"):
        parse_png(image)


@pytest.mark.parametrize("place", [20, 30, 45, 53])  # in the header, its checksum, the pixels, their checksum
def test_a_wrong_checksum_is_refused(place):
    wrong = bytearray(GOOD)
    wrong[place] ^= 0x10
    with pytest.raises(InvalidMap, match="cannot be read"):
        parse_png(bytes(wrong))


@pytest.mark.parametrize("size", [(0, 5), (5, 0), (1 << 14, 1 << 13), ((1 << 31) - 1, (1 << 31) - 1)])
def test_invalid_image_sizes_are_refused_before_decoding(size):
    with pytest.raises(InvalidMap, match=r"×.*pixels|cannot be read"):
        parse_png(header(*size) + chunk(b"IDAT", b"") + chunk(b"IEND"))
    assert MAX_PIXELS < (1 << 14) * (1 << 13)


@pytest.mark.parametrize(
    ("before", "fits"),
    [
        (chunk(b"tEXt", b"a\0b") * (MAX_OTHERS - 2), True),
        (chunk(b"tEXt", b"a\0b") * (MAX_OTHERS - 1), False),
        (chunk(b"abCd") * MAX_OTHERS, False),
        (chunk(b"iCCP", b"a\0\0" + zlib.compress(bytes(1 << 20))), True),
        (chunk(b"iCCP", b"a\0\0" + zlib.compress(bytes(1 << 20))) * 2, False),
        (chunk(b"IDAT") * (MAX_CHUNKS - 3), True),
        (chunk(b"IDAT") * MAX_CHUNKS, False),
    ],
    ids=[
        "many texts",
        "too many texts",
        "too many others",
        "a profile",
        "two profiles",
        "many parts",
        "too many parts",
    ],
)
def test_chunks_of_a_png_are_limited(before, fits):
    image = png([b"\x00\xfe"], 2, before=before)
    for read in (open_png, png_size):
        if fits:
            read(image)
        else:
            with pytest.raises(InvalidMap, match="too many chunks"):
                read(image)


@given(st.binary(max_size=60), st.integers(0, len(GOOD)))
def test_arbitrary_bytes_are_read_or_raise_invalid_map(rubbish, place):
    for image in (SIGNATURE + rubbish, GOOD[:place] + rubbish, GOOD[:place] + rubbish + GOOD[place + len(rubbish) :]):
        try:
            assert parse_png(image).dtype == np.uint8
        except InvalidMap as error:
            assert str(error)


@pytest.mark.parametrize("orientation", [1, 6])
def test_a_png_that_viewers_turn_by_its_exif_is_refused(orientation):
    exif, file = Image.Exif(), io.BytesIO()
    exif[274] = orientation
    Image.fromarray(np.zeros((2, 3), np.uint8)).save(file, "PNG", exif=exif)
    if orientation == 1:
        assert parse_png(file.getvalue()).shape[:2] == (2, 3)
        return
    with pytest.raises(InvalidMap, match=r"the PNG is turned \(orientation 6\): save the map's image upright"):
        parse_png(file.getvalue())

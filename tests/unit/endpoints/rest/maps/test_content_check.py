"""Small uploads that unpack to large maps, or have wrong headers, are refused and not stored."""

import io
import struct
import zlib

import httpx
import pytest
from PIL import Image
from PIL.ImageFile import ImageFile

from endpoints.resources.services import Services
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, pgm
from tests.unit.endpoints.conftest import LogIn, Publish


def png_of(width: int, height: int) -> bytes:
    """Return a PNG whose header has this size but which has almost no data."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 99)) + chunk(b"IEND", b"")


def padded_png() -> bytes:
    """Return a PNG with a text chunk that unpacks to 64 MiB."""
    kept = io.BytesIO()
    Image.new("L", (4, 3), 254).save(kept, "PNG")
    image = kept.getvalue()
    text = b"zTXt" + b"note\0\0" + zlib.compress(bytes(64 << 20))
    bomb = struct.pack(">I", len(text) - 4) + text + struct.pack(">I", zlib.crc32(text))
    return image[:33] + bomb + image[33:]


LAUGHS = b"a: &a [x, x, x, x, x, x, x, x, x]\n" + b"".join(
    b"%c: &%c [%s]\n" % (98 + n, 98 + n, b", ".join([b"*%c" % (97 + n)] * 9)) for n in range(12)
)

IMAGES = {
    "16 pixels in 12 bytes": b"P5\n4 4\n255\n" + bytes(12),
    "width 0": b"P5\n0 3\n255\n",
    "a size of ten digits": b"P5\n9999999999 9999999999\n255\n" + bytes(12),
    "a billion pixels": b"P5\n32768 32768\n255\n" + bytes(12),
    "a billion ASCII pixels": b"P2\n32768 32768\n255\n" + b"0 " * 12,
    "maximum 0": b"P5\n4 3\n0\n" + bytes(12),
    "a 16-bit maximum with 8-bit pixels": b"P5\n4 3\n65535\n" + bytes(12),
    "pixels above the maximum": b"P5\n4 3\n100\n" + bytes([101] * 12),
    "negative width": b"P5\n-4 3\n255\n" + bytes(12),
    "one pixel too many": b"P2\n4 3\n255\n" + b"0 " * 13,
    "a PNG of 65535 by 65535": png_of(65535, 65535),
    "a PNG of the largest size": png_of(2**31 - 1, 2**31 - 1),
    "a PNG with too few rows": png_of(4000, 4000),
    "a PNG with a text bomb": padded_png(),
}

RECORDS = {
    "laughs": LAUGHS + YAML,
    "aliases": b"origin: &o [0, 0, *o]\nimage: x\nresolution: 0.05\n",
    "nan": YAML.replace(b"0.05", b".nan"),
    "inf": YAML.replace(b"0.05", b".inf"),
    "nan origin": YAML.replace(b"-2.0", b".nan"),
    "no resolution": YAML.replace(b"0.05", b"0"),
    "an object": YAML + b"mode: !!python/object/apply:os.system ['id']\n",
    "deep": b"a: " + b"[" * 5000 + b"]" * 5000 + b"\n" + YAML,
    "long": YAML + b"#" * (1 << 16),
}


@pytest.mark.parametrize("image", IMAGES.values(), ids=IMAGES.keys())
async def test_invalid_images_are_refused_and_not_stored(
    log_in: LogIn, publish: Publish, services: Services, image: bytes
) -> None:
    problem_of(await publish(await log_in("ann"), image=image), 422, "invalid-map")
    assert services.map_store.maps() == []


@pytest.mark.parametrize("yaml", RECORDS.values(), ids=RECORDS.keys())
async def test_invalid_yaml_files_are_refused_and_not_stored(
    log_in: LogIn, publish: Publish, services: Services, yaml: bytes
) -> None:
    answer = await publish(await log_in("ann"), yaml=yaml, image=pgm())
    if yaml is RECORDS["laughs"]:  # these keys are ignored, so their aliases are never expanded
        assert answer.status_code in (201, 422)
        return
    problem_of(answer, 422, "invalid-map")
    assert services.map_store.maps() == []


async def test_a_map_is_shown_without_decoding_its_image(
    client: httpx.AsyncClient, publish: Publish, log_in: LogIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    header = await log_in("ann")
    kept = io.BytesIO()
    Image.new("RGBA", (40, 30), (254, 254, 254, 255)).save(kept, "PNG")
    assert (await publish(header, image=kept.getvalue())).status_code == 201
    monkeypatch.setattr(ImageFile, "load", None)
    for path in ("/v1/maps", "/v1/maps/house"):
        assert (await client.get(path, headers=header)).status_code == 200
    assert (await client.get("/v1/maps/house", headers=header)).json()["width"] == 40

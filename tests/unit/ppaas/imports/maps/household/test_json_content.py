import base64
import gzip
import io
import zlib

import msgspec
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from ppaas.errors import InvalidMap
from ppaas.imports.maps.household import json_content
from ppaas.imports.maps.household.json_content import decoded_json

TREE = {"pixelSize": 5, "layers": []}
JSON = msgspec.json.encode(TREE)


def png(text: str) -> bytes:
    notes, file = PngInfo(), io.BytesIO()
    notes.add_text("Author", "somebody", zip=True)
    notes.add_text("ValetudoMap", text, zip=True)
    Image.new("L", (2, 2)).save(file, "PNG", pnginfo=notes)
    return file.getvalue()


def packed_with_white_space_at_its_end() -> bytes:
    """Return JSON whose packed form ends with a byte that is white space as text."""
    packed = (zlib.compress(msgspec.json.encode(TREE) + b" " * count) for count in range(10_000))
    return next(each for each in packed if each != each.strip())


PACKED = {
    "zlib with white space at its end": packed_with_white_space_at_its_end(),
    "plain": JSON,
    "with a mark": b"\xef\xbb\xbf" + JSON,
    "zlib": zlib.compress(JSON),
    "gzip": gzip.compress(JSON),
    "base64": base64.b64encode(zlib.compress(JSON)) + b"\n",
    "png": png(JSON.decode()),
}


@pytest.mark.parametrize("content", PACKED.values(), ids=list(PACKED))
def test_json_is_found_however_it_is_packed(content):
    assert decoded_json(content) == TREE


def test_packed_json_that_is_too_large_is_refused(monkeypatch):
    monkeypatch.setattr(json_content, "MOST_BYTES", 1000)
    with pytest.raises(InvalidMap, match="MiB"):
        decoded_json(zlib.compress(b"[" + b" " * 10_000 + b"]"))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"{", "not valid JSON"),
        (b"[" * 100_000, "not valid JSON"),
        (b"\x78\x9cbroken", "damaged"),
        (b"\xff\xfe\x00", "neither JSON"),
        (png("no map"), "no map in its text"),
    ],
)
def test_what_is_no_json_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        decoded_json(content)

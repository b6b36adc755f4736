"""JSON of foreign maps as people have it: plain, packed by zlib or gzip, in Base64, or in a PNG."""

import base64
import binascii
import struct
import zlib
from typing import Any

import msgspec

from ppaas.bounded import inflated
from ppaas.errors import InvalidMap
from ppaas.maps.formats.pictures import MAGIC as PNG

MOST_BYTES = 1 << 27
"""Largest size of unpacked JSON [bytes]."""

_PACKED = (b"\x1f\x8b", b"\x78")
"""First bytes of gzip and of zlib."""

_ANY_HEADER = 32 + zlib.MAX_WBITS
"""Window of zlib that reads the headers of zlib and of gzip."""

_CHUNK = struct.Struct(">I4s")
_TEXT = b"zTXt"


def unpacked(content: bytes) -> bytes:
    """Return the JSON in a file.

    Raises
    ------
    InvalidMap
        It is packed, and damaged or larger than `MOST_BYTES`.
    """
    if content[:8] == PNG:
        content = _text_of_png(content)
    if content.startswith(_PACKED):
        return _inflated(content)
    text = content.removeprefix(b"\xef\xbb\xbf").strip()
    if text[:1] in (b"{", b"["):
        return text
    try:
        content = base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise InvalidMap("the file has neither JSON nor packed JSON") from error
    return _inflated(content) if content.startswith(_PACKED) else content


def decoded_json(content: bytes) -> Any:
    """Return the JSON of a file, decoded.

    Raises
    ------
    InvalidMap
        As ``unpacked``; or it is not JSON.
    """
    try:
        return msgspec.json.decode(unpacked(content))
    except (msgspec.DecodeError, RecursionError) as error:
        raise InvalidMap(f"the file is not valid JSON: {error}") from error


def _inflated(packed: bytes) -> bytes:
    try:
        return inflated(packed, MOST_BYTES, _ANY_HEADER)
    except zlib.error as error:
        raise InvalidMap(f"the packed JSON is damaged: {error}") from error
    except OverflowError as error:
        raise InvalidMap(f"the packed JSON has more than {MOST_BYTES >> 20} MiB") from error


def _text_of_png(picture: bytes) -> bytes:
    """Return the packed text of the first chunk of text whose content is JSON."""
    at = len(PNG)
    while at + _CHUNK.size <= len(picture):
        length, kind = _CHUNK.unpack_from(picture, at)
        body = picture[at + _CHUNK.size : at + _CHUNK.size + length]
        at += _CHUNK.size + length + 4
        if kind == _TEXT:
            _, _, packed = body.partition(b"\0")
            text = _inflated(packed[1:])
            if text.lstrip()[:1] == b"{":
                return text
    raise InvalidMap("the PNG has no map in its text: import it as a floor plan with 'ppaas map from-plan'")

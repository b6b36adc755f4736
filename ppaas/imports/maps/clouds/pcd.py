"""PCD files of the Point Cloud Library: ascii, binary and binary_compressed.

Source: the page of the format in the documents of PCL. Names of fields need not be unique: padding has ``_``.
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.clouds.number_text import number_table
from ppaas.imports.maps.clouds.point_cloud import PointCloud, ScanOrigin, check_count, check_size, cloud_of
from ppaas.imports.report import ImportReport

MAX_HEADER = 1 << 16
"""Limit of the size of a header [bytes]."""

MOST_OF_LZF = 150
"""Largest ratio of sizes that LZF reaches: three bytes stand for up to 264."""

_TYPES = {b"F": "f", b"I": "i", b"U": "u"}
_SIZES = (1, 2, 4, 8)
_AXES = (b"x", b"y", b"z")
_Columns = tuple[NDArray[np.generic], NDArray[np.generic], NDArray[np.generic]]


@dataclass(frozen=True, slots=True)
class _Header:
    names: list[bytes]
    formats: list[str]
    counts: list[int]
    points: int
    encoding: bytes
    viewpoint: tuple[float, ...]
    body: int

    @property
    def point_size(self) -> int:
        return sum(int(form[1:]) * count for form, count in zip(self.formats, self.counts, strict=True))

    def axis(self, name: bytes) -> int:
        if name not in self.names:
            raise InvalidMap(f"the PCD has no field {name.decode()!r}: its fields are {b' '.join(self.names)!r}")
        return self.names.index(name)


def read_pcd(content: bytes, report: ImportReport) -> PointCloud:
    """Read a PCD file.

    Raises
    ------
    InvalidMap
        It is no PCD file, it is truncated, or it has too many points.
    """
    header = _header(content)
    check_count(header.points, "PCD")
    readers = {b"ascii": _ascii, b"binary": _binary, b"binary_compressed": _compressed}
    if header.encoding not in readers:
        raise InvalidMap(f"the PCD has unknown DATA {header.encoding!r}; known: ascii, binary, binary_compressed")
    columns = readers[header.encoding](content, header)
    others = [name.decode("ascii", "replace") for name in header.names if name not in (*_AXES, b"_")]
    if others:
        report.without_effect("fields", f"{', '.join(others)}: a map has places alone")
    cloud = cloud_of(columns, report)
    place = header.viewpoint[:3]
    if len(place) < 3 or not np.isfinite(place).all():
        report.refused("VIEWPOINT", "it must be seven finite numbers: the place of the sensor is not known")
        return cloud
    if not any(place):
        return cloud
    x, y, z = (np.array(place) - cloud.offset).tolist()
    report.taken("VIEWPOINT", f"the sensor was at x={place[0]:.2f}, y={place[1]:.2f}, z={place[2]:.2f}")
    return PointCloud(cloud.points, cloud.offset, (ScanOrigin((x, y, z), 0, len(cloud.points)),))


def _header(content: bytes) -> _Header:
    words: dict[bytes, list[bytes]] = {}
    at = 0
    while b"DATA" not in words:
        end = content.find(b"\n", at, MAX_HEADER)
        if end < 0:
            raise InvalidMap("the header of the PCD has no end: the line DATA is missing")
        key, *values = content[at:end].split() or [b"#"]
        at = end + 1
        if not key.startswith(b"#"):
            words[key.upper()] = values
    try:
        return _parsed(words, at)
    except (ValueError, IndexError, KeyError) as error:
        raise InvalidMap(f"the header of the PCD is not valid: {error}") from error


def _parsed(words: dict[bytes, list[bytes]], body: int) -> _Header:
    names = [name.lower() for name in words.get(b"FIELDS") or words[b"COLUMNS"]]
    sizes, kinds = [int(size) for size in words[b"SIZE"]], words[b"TYPE"]
    counts = [int(count) for count in words.get(b"COUNT", [b"1"] * len(names))]
    if not len(names) == len(sizes) == len(kinds) == len(counts):
        raise ValueError("FIELDS, SIZE, TYPE and COUNT have different lengths")
    if any(size not in _SIZES for size in sizes) or any(not 0 <= count <= 1 << 16 for count in counts):
        raise ValueError("SIZE must be 1, 2, 4 or 8, and COUNT from 0 to 65536")
    formats = [f"{_TYPES[kind.upper()]}{size}" for kind, size in zip(kinds, sizes, strict=True)]
    if "f1" in formats:
        raise ValueError("a float has 2 bytes or more")
    points = int(words[b"POINTS"][0]) if b"POINTS" in words else int(words[b"WIDTH"][0]) * int(words[b"HEIGHT"][0])
    viewpoint = tuple(float(value) for value in words.get(b"VIEWPOINT", [])) or (0.0,) * 7
    return _Header(names, formats, counts, points, words[b"DATA"][0].lower(), viewpoint, body)


def _binary(content: bytes, header: _Header) -> _Columns:
    check_size(header.points * header.point_size, len(content) - header.body, "PCD")
    fields = [f"f{number}" for number in range(len(header.names))]  # padding may repeat a name
    form = np.dtype([
        (field, f"<{kind}", (count,)) if count != 1 else (field, f"<{kind}")
        for field, kind, count in zip(fields, header.formats, header.counts, strict=True)
    ])  # fmt: skip
    table = np.frombuffer(content, form, header.points, header.body)
    x, y, z = (table[fields[header.axis(axis)]] for axis in _AXES)
    return x, y, z


def _compressed(content: bytes, header: _Header) -> _Columns:
    """Read compressed points, of which one field is behind the other."""
    try:
        import lzf  # noqa: PLC0415 - needed for this encoding alone
    except ImportError as error:
        raise InvalidInput(
            f"compressed PCD files need python-neo-lzf: {install_hint('clouds')}; or save the file as binary"
        ) from error
    check_size(8, len(content) - header.body, "PCD")
    packed, unpacked = struct.unpack_from("<II", content, header.body)
    check_size(packed, len(content) - header.body - 8, "PCD")
    size = header.points * header.point_size
    if unpacked != size or unpacked > packed * MOST_OF_LZF:
        raise InvalidMap(
            f"the PCD states {header.points} points of {size} bytes, which its {packed} compressed bytes cannot have: "
            f"they state {unpacked}"
        )
    try:
        body = lzf.decompress(content[header.body + 8 : header.body + 8 + packed], unpacked)
    except ValueError as error:
        raise InvalidMap("the compressed part of the PCD is damaged") from error
    if body is None or len(body) != unpacked:
        raise InvalidMap("the compressed part of the PCD is damaged")
    columns = []
    for axis in _AXES:
        number = header.axis(axis)
        before = zip(header.formats[:number], header.counts[:number], strict=True)
        begin = sum(int(form[1:]) * count for form, count in before) * header.points
        columns.append(np.frombuffer(body, f"<{header.formats[number]}", header.points, begin))
    x, y, z = columns
    return x, y, z


def _ascii(content: bytes, header: _Header) -> _Columns:
    width = sum(header.counts)
    check_size(header.points * width * 2 - 1, len(content) - header.body, "PCD")
    table = number_table(content[header.body :], "PCD", width)
    if len(table) < header.points:
        raise InvalidMap(f"the PCD states {header.points} points, but has {len(table)}")
    x, y, z = (table[: header.points, sum(header.counts[: header.axis(axis)])] for axis in _AXES)
    return x, y, z

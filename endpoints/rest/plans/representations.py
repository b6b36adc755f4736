"""Representations of paths: JSON or CBOR, by the header ``Accept``; their poses in full, in short, or as a polyline.

Source of polylines: Google Maps Platform, *Encoded Polyline Algorithm Format*. Decoders take the number of decimals as
precision.
"""

from collections.abc import Mapping
from enum import StrEnum
from functools import partial
from typing import Annotated, Any, NamedTuple

import msgspec
import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from starlette.requests import Request

from endpoints.rest.openapi import Responses
from ppaas.geometry import Poses

JSON, CBOR = "application/json", "application/cbor"

_ARRAY, _FLOATS = 40, 86
"""Tags of RFC 8746: an array of several dimensions, row by row; float64, little endian."""


_FORMS = (
    "`rows`: x, y, z [m], qx, qy, qz, qw a pose; `xyyaw`: x, y [m], yaw [rad]; `polyline`: x and y alone, in "
    "millimetres, as text in the Encoded Polyline Algorithm Format with a precision of 3"
)


class PoseForm(StrEnum):
    """Form of the poses of a path."""

    ROWS = "rows"
    XYYAW = "xyyaw"
    POLYLINE = "polyline"


class Representation(NamedTuple):
    """Media type of an answer, and form of its poses."""

    media_type: str = JSON
    form: PoseForm = PoseForm.ROWS

    def encode(self, fields: Mapping[str, Any]) -> bytes:
        """Return the body of an answer with these fields, of which ``poses`` is an (n, 7) array."""
        if self.media_type == CBOR:
            return _cbor(fields, self.form)
        return _ENCODERS[self.form].encode(fields)


async def asked(
    request: Request,
    poses: Annotated[PoseForm, Query(description=_FORMS)] = PoseForm.ROWS,
) -> Representation:
    """Return the representation that a request asks for."""
    return Representation(preferred(",".join(request.headers.getlist("accept"))), poses)


def preferred(accept: str) -> str:
    """Return `CBOR` if a header ``Accept`` prefers it to JSON; also other types than these get JSON.

    A type counts by its most specific range, and of two equal weights JSON is taken (RFC 9110, section 12.5.1).
    """
    if not accept or accept in (JSON, "*/*"):
        return JSON
    ranges = dict(map(_range, accept.split(",")))
    weights = [
        next((ranges[name] for name in (media_type, "application/*", "*/*") if name in ranges), 0.0)
        for media_type in (JSON, CBOR)
    ]
    return CBOR if weights[1] > weights[0] else JSON


def _range(text: str) -> tuple[str, float]:
    """Return a range of media types in lower case without its parameters, and its weight."""
    name, *parameters = (part.strip().lower() for part in text.split(";"))
    weight = next((part[2:] for part in parameters if part.startswith("q=")), "1")
    try:
        return name, min(max(float(weight), 0.0), 1.0)
    except ValueError:
        return name, 0.0


def described(*statuses: int) -> Responses:
    """Return the representations that OpenAPI lists beside JSON for these statuses."""
    text = {"type": "string", "format": "binary", "description": "The same fields; `poses` as an array of RFC 8746"}
    return {status: {"content": {CBOR: {"schema": text}}} for status in statuses}


def short(poses: Poses) -> NDArray[np.float64]:
    """Return (n, 3) rows x, y [m], yaw [rad] of (n, 7) poses."""
    qx, qy, qz, qw = poses[:, 3:].T
    yaw = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    return np.column_stack((poses[:, :2], yaw))


def _in_json(form: PoseForm, poses: Poses) -> msgspec.Raw | str:
    # Imported here: numba takes a third of a second, and the process that unpacks a path has loaded it.
    from ppaas.planners.path_json import rows_json  # noqa: PLC0415

    if form is PoseForm.POLYLINE:
        return polyline_of(poses[:, :2])
    return rows_json(short(poses) if form is PoseForm.XYYAW else poses)


_ENCODERS: Mapping[PoseForm, msgspec.json.Encoder] = {
    form: msgspec.json.Encoder(enc_hook=partial(_in_json, form)) for form in PoseForm
}


def _cbor(fields: Mapping[str, Any], form: PoseForm) -> bytes:
    import cbor2  # noqa: PLC0415

    plain = {name: _plain(value, form) for name, value in fields.items()}
    encoded: bytes = cbor2.dumps(plain)
    return encoded


def _plain(value: Any, form: PoseForm) -> Any:
    import cbor2  # noqa: PLC0415

    if isinstance(value, msgspec.Raw):
        return msgspec.json.decode(value)
    if not isinstance(value, np.ndarray):
        return value
    if form is PoseForm.POLYLINE:
        return polyline_of(value[:, :2])
    rows = short(value) if form is PoseForm.XYYAW else value
    return cbor2.CBORTag(_ARRAY, [list(rows.shape), cbor2.CBORTag(_FLOATS, rows.astype("<f8", copy=False).tobytes())])


# -- polylines as text, by the Encoded Polyline Algorithm Format: some four characters a point -------------------------

DECIMALS = 3
"""Decimals of a coordinate in metres: points are rounded to millimetres."""

_BITS, _MORE, _OFFSET = 5, 0x20, 63


def polyline_of(points: NDArray[np.float64], decimals: int = DECIMALS) -> str:
    """Return (n, 2) points as text: x and y of the first, then the differences to the point before."""
    rounded = np.rint(points * 10.0**decimals).astype(np.int64)
    steps = np.diff(rounded, axis=0, prepend=np.zeros((1, 2), np.int64)).reshape(-1)
    values = (steps << 1) ^ (steps >> 63)  # the sign is the last bit
    widest = max(int(values.max(initial=1)).bit_length(), 1)
    parts = values[:, None] >> np.arange(0, widest, _BITS)
    is_used = parts != 0
    is_used[:, 0] = True
    characters = (parts & (_MORE - 1)) + _OFFSET
    characters[:, :-1] += _MORE * is_used[:, 1:]
    return str(characters[is_used].astype(np.uint8).tobytes(), "ascii")

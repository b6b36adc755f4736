"""YAML record of a map, which map_server and Nav2 read beside the image."""

import math
from enum import Enum
from typing import Annotated, Any

import msgspec
import yaml
from msgspec import Meta

from ppaas.errors import InvalidMap

MAX_YAML = 1 << 16
"""Limit of the size of a record [bytes]."""

_MAX_BRACKETS = 100

_Threshold = Annotated[float, Meta(ge=0.0, le=1.0)]


class Mode(Enum):
    """Mapping from grey to occupancy."""

    TRINARY = "trinary"
    SCALE = "scale"
    RAW = "raw"


class Rules(Enum):
    """Rules of the mapping; they differ at the thresholds, and for images with colours or alpha."""

    MAP_SERVER = "map_server"
    NAV2 = "nav2"


class MapYaml(msgspec.Struct, frozen=True, kw_only=True):
    """Keys of a map's record.

    Parameters
    ----------
    image : str
        Name of the image file.
    resolution : float
        Edge of a pixel [m].
    origin : tuple of float
        x, y [m] and yaw [rad] of the lower-left corner of the lower-left pixel.
    negate : bool
        Whether white is occupied and black is free.
    occupied_thresh, free_thresh : float
        Occupancy (0 to 1) above which a cell is occupied, and below which it is free.
    mode : Mode
        ``trinary``: free, occupied, unknown. ``scale``: graded between the thresholds. ``raw``: the pixel is the value.
    rules : Rules
        ``map_server`` or ``nav2``. This key is an extension of PPaaS, which both programs ignore; nothing else in the
        file says which of them it was made for.
    """

    image: Annotated[str, Meta(min_length=1)]
    resolution: Annotated[float, Meta(gt=0.0)]
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: _Threshold = 0.65
    free_thresh: _Threshold = 0.196
    mode: Mode = Mode.TRINARY
    rules: Rules = Rules.MAP_SERVER

    def __post_init__(self) -> None:
        numbers = (self.resolution, *self.origin, self.occupied_thresh, self.free_thresh)
        if not all(map(math.isfinite, numbers)):
            raise ValueError("resolution, origin, occupied_thresh and free_thresh must be finite")
        if self.free_thresh >= self.occupied_thresh:
            raise ValueError(f"free_thresh {self.free_thresh} must be below occupied_thresh {self.occupied_thresh}")


# PyYAML's own errors, and those that its constructors let through for scalars such as `!!bool x`.
_YAML_ERRORS = (yaml.YAMLError, ValueError, KeyError, AttributeError, RecursionError)


def parse_yaml(record: bytes, rules: Rules | None = None) -> MapYaml:
    """Parse the record of a map.

    Parameters
    ----------
    record : bytes
        The YAML file.
    rules : Rules, optional
        Replace the rules that the record names.

    Raises
    ------
    InvalidMap
        The record is not YAML, or a key is missing or invalid; the text names the key.
    """
    keys = _load(record)
    try:
        # Not strict: 5e-2 and "0.05" are strings in YAML 1.1, but numbers for map_server.
        parsed = msgspec.convert(keys, MapYaml, strict=False)
    except (msgspec.ValidationError, RecursionError) as error:
        raise InvalidMap(f"the map's YAML is not a map_server record: {error}") from error
    if rules is not None:
        parsed = msgspec.structs.replace(parsed, rules=rules)
    if parsed.rules is Rules.NAV2:
        _check_nav2_keys(keys)
    return parsed


def with_rules(record: bytes, rules: Rules) -> bytes:
    """Return the record with the key ``rules`` set; if its value changes, comments are lost.

    Raises
    ------
    InvalidMap
        As for ``parse_yaml``.
    """
    parse_yaml(record, rules)
    keys = _load(record)
    if Rules(keys.get("rules", Rules.MAP_SERVER.value)) is rules:
        return record
    return dump_yaml(keys | {"rules": rules.value})


def dump_yaml(keys: dict[str, Any]) -> bytes:
    """Return the YAML of a record with these keys."""
    return yaml.safe_dump(keys, sort_keys=False, default_flow_style=None).encode()


def _load(record: bytes) -> Any:
    if len(record) > MAX_YAML:
        raise InvalidMap(f"the map's YAML has {len(record)} bytes; at most {MAX_YAML} are allowed")
    if record.count(b"[") + record.count(b"{") > _MAX_BRACKETS:  # deeply nested brackets take the parser seconds
        raise InvalidMap(f"the map's YAML cannot be read: it has more than {_MAX_BRACKETS} brackets")
    try:
        return yaml.safe_load(record)
    except _YAML_ERRORS as error:
        raise InvalidMap(f"the map's YAML cannot be read: {error}") from error


def _check_nav2_keys(keys: dict[str, Any]) -> None:
    for name in ("occupied_thresh", "free_thresh"):
        if name not in keys:
            raise InvalidMap(
                f"the map's YAML lacks `{name}`, which Nav2's rules require: add it, or use map_server's rules"
            )

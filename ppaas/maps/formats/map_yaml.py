"""YAML record of a map, which map_server and Nav2 read beside the image."""

import math
import re
from collections.abc import Mapping
from enum import Enum
from typing import Annotated, Any

import msgspec
import yaml
from msgspec import Meta

from ppaas.decoding import converted
from ppaas.errors import InvalidMap
from ppaas.maps.yaml_keys import Value, read_keys, with_key

MAX_YAML = 1 << 16
"""Limit of the size of a record [bytes]."""

_NUMBER = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
"""Numbers as C++ streams read them, and so map_server and Nav2."""

_WORDS = {"y": True, "yes": True, "true": True, "on": True, "n": False, "no": False, "false": False, "off": False}

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
        Occupancy (0 to 1) above which a cell is occupied, and below which it is free. If both apply, the rules decide.
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
    given = _values(keys)
    if rules is not None:
        given["rules"] = rules
    try:
        parsed = converted(given, MapYaml)
    except msgspec.ValidationError as error:
        raise _refused(str(error)) from error
    if parsed.rules is Rules.NAV2:
        _check_nav2_keys(keys)
    return parsed


def with_rules(record: bytes, rules: Rules) -> bytes:
    """Return the record with the key ``rules`` set; nothing else changes.

    Raises
    ------
    InvalidMap
        As for ``parse_yaml``.
    """
    parse_yaml(record, rules)
    if _load(record).get("rules", Rules.MAP_SERVER.value) == rules.value:
        return record
    return with_key(record, "rules", rules.value)


def with_image(record: bytes, name: str) -> bytes:
    """Return the record with another name of the image; nothing else changes. Raises as ``parse_yaml`` does."""
    parse_yaml(record)
    return with_key(record, "image", name)


def dump_yaml(keys: dict[str, Any]) -> bytes:
    """Return the YAML of a record with these keys."""
    return yaml.safe_dump(keys, sort_keys=False, default_flow_style=None).encode()


def _load(record: bytes) -> Mapping[str, Value]:
    if len(record) > MAX_YAML:
        raise InvalidMap(f"the map's YAML has {len(record)} bytes; at most {MAX_YAML} are allowed")
    keys = read_keys(record)
    if keys is None:
        raise _refused("it must have the keys `image`, `resolution` and `origin`, each with a value")
    return keys


def _values(keys: Mapping[str, Value]) -> dict[str, Any]:
    """Return the keys of `MapYaml` with their values as numbers, booleans and text."""
    given: dict[str, Any] = {name: keys[name] for name in ("image", "rules") if name in keys}
    given |= {
        name: _number(name, keys[name]) for name in ("resolution", "occupied_thresh", "free_thresh") if name in keys
    }
    if "origin" in keys:
        given["origin"] = _origin(keys["origin"])
    if "negate" in keys:
        given["negate"] = _boolean("negate", keys["negate"])
    if isinstance(mode := keys.get("mode"), str):
        given["mode"] = mode.lower()
    elif mode is not None:
        raise _refused("`mode` must be a word")
    return given


def _number(name: str, value: Value) -> float:
    if not (isinstance(value, str) and _NUMBER.fullmatch(value)):
        raise _refused(f"`{name}` must be a finite number, as 0.05, not {_shown(value)}")
    return float(value)


def _origin(value: Value) -> tuple[float, ...]:
    """Return x, y and yaw. Further numbers are ignored, as map_server does."""
    if not isinstance(value, list) or len(value) < 3:
        raise _refused(f"`origin` must be a list of x, y [m] and yaw [rad], not {_shown(value)}")
    return tuple(_number("origin", each) for each in value[:3])


def _boolean(name: str, value: Value) -> bool:
    if isinstance(value, str) and value.lower() in _WORDS:
        return _WORDS[value.lower()]
    return _number(name, value) != 0.0


def _shown(value: Value) -> str:
    if isinstance(value, str):
        return ascii(value[:40])
    return "nothing" if value is None else "a list" if isinstance(value, list) else "a mapping"


def _refused(why: str) -> InvalidMap:
    return InvalidMap(f"the map's YAML is not a map_server record: {why}")


def _check_nav2_keys(keys: Mapping[str, Value]) -> None:
    origin = keys["origin"]
    if isinstance(origin, list) and len(origin) != 3:
        raise _refused(f"`origin` must have three numbers by Nav2's rules, not {len(origin)}")
    for name in ("occupied_thresh", "free_thresh"):
        if name not in keys:
            raise InvalidMap(
                f"the map's YAML lacks `{name}`, which Nav2's rules require: add it, or use map_server's rules"
            )

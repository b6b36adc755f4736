"""Observations as JSON, which has neither NaN nor infinity, for another process."""

import math
import sys
from typing import Any

import msgspec

from ppaas.decoding import from_json
from ppaas.diagnosis.observations.facts import Observations


def observations_to_json(seen: Observations) -> str:
    """Return observations as JSON; numbers that a robot has driven beyond all bounds are the largest ones, NaN is 0."""
    return msgspec.json.encode(_finite(msgspec.to_builtins(seen))).decode()


def observations_from_json(text: str) -> Observations:
    """Return the observations of a JSON text; raises ``msgspec.DecodeError`` if it is none of ours."""
    return from_json(text, Observations)


def _finite(value: Any) -> Any:
    match value:
        case float() if not math.isfinite(value):
            return 0.0 if math.isnan(value) else math.copysign(sys.float_info.max, value)
        case dict():
            return {key: _finite(each) for key, each in value.items()}
        case list() | tuple():
            return [_finite(each) for each in value]
        case _:
            return value

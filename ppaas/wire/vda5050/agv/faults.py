"""Errors that an AGV reports, named as in 3.0; the codec spells them as in 2.x.

Source: VDA 5050 3.0, table of predefined error types.
"""

from collections.abc import Mapping

from ppaas.wire.vda5050.fields import Reference
from ppaas.wire.vda5050.states import Error, ErrorLevel

VALIDATION_FAILURE = "VALIDATION_FAILURE"
UNSUPPORTED_PARAMETER = "UNSUPPORTED_PARAMETER"
INVALID_ORDER_ACTION = "INVALID_ORDER_ACTION"
INVALID_INSTANT_ACTION = "INVALID_INSTANT_ACTION"
OUTDATED_ORDER_UPDATE = "OUTDATED_ORDER_UPDATE"
SAME_ORDER_UPDATE_ID = "SAME_ORDER_UPDATE_ID"
ORDER_UPDATE_FOLLOWING_CANCEL = "ORDER_UPDATE_FOLLOWING_CANCEL"
OTHER_ORDER_ACTIVE = "OTHER_ORDER_ACTIVE"
START_NODE_OUT_OF_RANGE = "START_NODE_OUT_OF_RANGE"
NO_ORDER_TO_CANCEL = "NO_ORDER_TO_CANCEL"
MOBILE_ROBOT_NOT_AVAILABLE = "MOBILE_ROBOT_NOT_AVAILABLE"
UNKNOWN_MAP_ID = "UNKNOWN_MAP_ID"
NODE_UNREACHABLE = "NODE_UNREACHABLE"
LOCALIZATION_ERROR = "LOCALIZATION_ERROR"
DUPLICATE_ZONE_SET = "DUPLICATE_ZONE_SET"
INVALID_ZONE_SET = "INVALID_ZONE_SET"

MAX_TEXT = 500
"""Largest length of a description [characters]."""


class OrderRefused(Exception):
    """An order, an action or a set of zones is refused.

    Parameters
    ----------
    kind : str
        Type of the error.
    text : str
        Description of the fault and its remedy.
    references : mapping of str to str
        References of the error, by key.
    level : str
        Level of the error.
    """

    def __init__(self, kind: str, text: str, references: Mapping[str, str], level: ErrorLevel = "WARNING") -> None:
        super().__init__(text)
        self.error = fault(kind, level, text, references)


def order_ids(order_id: str, update_id: int) -> dict[str, str]:
    """Return the references of an error to an order."""
    return {"orderId": order_id, "orderUpdateId": str(update_id)}


def fault(kind: str, level: ErrorLevel, text: str, references: Mapping[str, str]) -> Error:
    """Return an error."""
    return Error(
        error_type=kind,
        error_level=level,
        error_description=text[:MAX_TEXT],
        error_references=[Reference(reference_key=key, reference_value=value) for key, value in references.items()],
    )

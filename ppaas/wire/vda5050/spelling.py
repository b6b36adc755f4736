"""Spelling of messages in 2.x and 3.0: fields and values that have other names, and fields that one of them lacks.

Messages are trees of dicts and lists here, as JSON has them. Values of action parameters are left alone.
"""

from collections.abc import Callable, Mapping
from typing import Any

from ppaas.wire.vda5050 import topics

Tree = dict[str, Any]
Names = Mapping[str, str]

NODE_NAMES = {
    "nodeDescription": "nodeDescriptor",
    "edgeDescription": "edgeDescriptor",
    "actionDescription": "actionDescriptor",
}
ORDER_NAMES = {
    **NODE_NAMES,
    "maxSpeed": "maximumSpeed",
    "maxHeight": "maximumMobileRobotHeight",
    "minHeight": "minimumLoadHandlingDeviceHeight",
    "corridorRefPoint": "corridorReferencePoint",
}
POSITION_NAMES = {"agvPosition": "mobileRobotPosition", "positionInitialized": "localized"}
STATE_NAMES = {
    **NODE_NAMES,
    **POSITION_NAMES,
    "mapDescription": "mapDescriptor",
    "resultDescription": "actionResult",
    "infoDescription": "infoDescriptor",
    "batteryState": "powerSupply",
    "batteryCharge": "stateOfCharge",
    "reach": "range",
    "eStop": "activeEmergencyStop",
}
FACTSHEET_NAMES = {
    "agvKinematic": "mobileRobotKinematics",
    "agvClass": "mobileRobotClass",
    "maxLoadMass": "maximumLoadMass",
    "speedMin": "minimumSpeed",
    "speedMax": "maximumSpeed",
    "accelerationMax": "maximumAcceleration",
    "decelerationMax": "maximumDeceleration",
    "heightMin": "minimumHeight",
    "heightMax": "maximumHeight",
    "maxStringLens": "maximumStringLengths",
    "msgLen": "maximumMessageLength",
    "topicSerialLen": "maximumTopicSerialLength",
    "topicElemLen": "maximumTopicElementLength",
    "idLen": "maximumIdLength",
    "loadIdLen": "maximumLoadIdLength",
    "maxArrayLens": "maximumArrayLengths",
    "minOrderInterval": "minimumOrderInterval",
    "minStateInterval": "minimumStateInterval",
    "agvActions": "mobileRobotActions",
    "resultDescription": "actionResult",
    "agvGeometry": "mobileRobotGeometry",
    "set": "envelope2dId",
    "polygonPoints": "vertices",
    "vehicleConfig": "mobileRobotConfiguration",
}
NAMES_2: dict[str, Names] = {
    topics.ORDER: ORDER_NAMES,
    topics.INSTANT_ACTIONS: NODE_NAMES,
    topics.STATE: STATE_NAMES,
    topics.VISUALIZATION: POSITION_NAMES,
    topics.FACTSHEET: FACTSHEET_NAMES,
}
"""Names of fields in 2.x with those in 3.0, by topic."""

VALUES_2: dict[str, Names] = {
    "connectionState": {"CONNECTIONBROKEN": "CONNECTION_BROKEN"},
    "operatingMode": {"TEACHIN": "TEACH_IN"},
    "corridorReferencePoint": {"KINEMATICCENTER": "KINEMATIC_CENTER"},
    "mobileRobotKinematics": {"DIFF": "DIFFERENTIAL", "OMNI": "OMNIDIRECTIONAL", "THREEWHEEL": "THREE_WHEEL"},
    "navigationTypes": {"AUTONOMOUS": "FREELY_NAVIGATING"},
}
"""Values in 2.x with those in 3.0, by the name of the field in 3.0."""

_VALUE_FIELDS = {"agvKinematic": "mobileRobotKinematics", "corridorRefPoint": "corridorReferencePoint"}

ONLY_3: dict[str, Names] = {
    "errorLevel": {"URGENT": "WARNING", "CRITICAL": "FATAL"},
    "actionStatus": {"RETRIABLE": "FAILED"},
    "operatingMode": {"STARTUP": "SERVICE", "INTERVENED": "MANUAL"},
    "blockingType": {"SINGLE": "HARD"},
    "blockingTypes": {"SINGLE": "HARD"},
    "connectionState": {"HIBERNATING": "OFFLINE"},
    "errorType": {
        "VALIDATION_FAILURE": "validationError",
        "UNSUPPORTED_PARAMETER": "orderError",
        "INVALID_ORDER_ACTION": "orderError",
        "INVALID_INSTANT_ACTION": "instantActionError",
        "OUTDATED_ORDER_UPDATE": "orderUpdateError",
        "SAME_ORDER_UPDATE_ID": "orderUpdateError",
        "ORDER_UPDATE_FOLLOWING_CANCEL": "orderUpdateError",
        "OTHER_ORDER_ACTIVE": "orderError",
        "START_NODE_OUT_OF_RANGE": "noRouteError",
        "NO_ORDER_TO_CANCEL": "noOrderToCancel",
        "MOBILE_ROBOT_NOT_AVAILABLE": "orderError",
        "UNKNOWN_MAP_ID": "orderError",
        "NODE_UNREACHABLE": "noRouteError",
        "LOCALIZATION_ERROR": "localizationError",
    },
}
"""Values that 2.x lacks, with the nearest that it has."""

WHOLE = frozenset({"headerId", "sequenceId", "orderUpdateId", "lastNodeSequenceId", "degree", "referenceStateHeaderId"})
"""Fields with whole numbers, which some peers write as ``1.0``."""

ARBITRARY = frozenset({"value", "loadSpecification", "mobileRobotConfiguration", "envelopes3d"})
"""Fields whose values pass as they are: parameters of actions, and what no robot of ours has."""

Rule = Callable[[str, Any], Any]


def from_version_2(topic: str, message: Tree) -> Tree:
    """Return a message of 2.x with the names and values of 3.0."""
    spelled: Tree = _renamed(message, NAMES_2.get(topic, {}), _value_to_3)
    if topic == topics.STATE:
        spelled.setdefault("instantActionStates", [])
    if topic == topics.INSTANT_ACTIONS and topic in spelled:
        spelled.setdefault("actions", spelled[topic])  # as the text of 2.0 named them, and some peers do
    return spelled


def name_in_version_2(topic: str, field: str) -> str:
    """Return the name in 2.x of a field that has another one in 3.0."""
    return _REVERSED.get(topic, {}).get(field, field)


def from_version_3(message: Tree) -> Tree:
    """Return a message of 3.0 with whole numbers that are ints."""
    spelled: Tree = _renamed(message, {}, _whole)
    return spelled


def to_version_2(topic: str, message: Tree) -> Tree:
    """Return a message with the names and values of 2.x, without fields that 3.0 alone has."""
    spelled: Tree = _renamed(message, _REVERSED.get(topic, {}), _value_to_2)
    if topic == topics.STATE:
        spelled["actionStates"] = [*spelled["actionStates"], *spelled.pop("instantActionStates")]
    fields = _ONLY_3_FIELDS.get(topic)
    return _without(spelled, fields) if fields else spelled


def to_version_3(topic: str, message: Tree) -> Tree:
    """Return a message without the fields that 2.x alone has."""
    fields = _ONLY_2_FIELDS.get(topic)
    return _without(message, fields) if fields else message


_REVERSED = {topic: {new: old for old, new in names.items()} for topic, names in NAMES_2.items()}

_VALUES_TO_2: dict[str, Names] = {
    field: {**{new: old for old, new in VALUES_2.get(field, {}).items()}, **ONLY_3.get(field, {})}
    for field in VALUES_2.keys() | ONLY_3.keys()
}

_ONLY_2_FIELDS = {
    topics.ORDER: frozenset({"startNodeId", "endNodeId", "rotationAllowed", "zoneSetId"}),
}
_ONLY_3_FIELDS = {
    topics.ORDER: frozenset(
        {"orderDescription", "reachOrientationBeforeEntering", "releaseRequired", "releaseLossBehavior", "retriable"}
    ),
    topics.INSTANT_ACTIONS: frozenset({"retriable"}),
    topics.STATE: frozenset(
        {
            "batteryCurrent",
            "edgeRequests",
            "errorDescriptionTranslations",
            "errorHintTranslations",
            "intermediatePath",
            "plannedPath",
            "zoneActionStates",
            "zoneRequests",
            "zoneSets",
        }
    ),
    topics.VISUALIZATION: frozenset({"referenceStateHeaderId", "plannedPath", "intermediatePath"}),
    topics.FACTSHEET: frozenset(
        {
            "supportedZones",
            "minimumAngularSpeed",
            "maximumAngularSpeed",
            "pauseAllowed",
            "cancelAllowed",
            "blockingTypes",  # the schemas of 2.x allow no value of it
        }
    ),
}


def _renamed(message: Any, names: Names, rule: Rule) -> Any:
    """Return a tree with other names of its fields; ``rule`` gives each value by the name that it had."""
    if isinstance(message, list):
        return [_renamed(one, names, rule) for one in message]
    if not isinstance(message, dict):
        return message
    return {
        names.get(key, key): value if key in ARBITRARY else _renamed(rule(key, value), names, rule)
        for key, value in message.items()
    }


def _whole(field: str, value: Any) -> Any:
    return int(value) if field in WHOLE and isinstance(value, float) and value.is_integer() else value


def _value_to_3(field: str, value: Any) -> Any:
    if field == "allowedDeviationXY" and isinstance(value, int | float) and not isinstance(value, bool):
        return {"a": value, "b": value, "theta": 0.0}
    return _translated(VALUES_2.get(_VALUE_FIELDS.get(field, field)), _whole(field, value))


def _value_to_2(field: str, value: Any) -> Any:
    if field == "allowedDeviationXY":
        return min(value["a"], value["b"])
    if field == "batteryHealth":
        return round(value)  # 2.0 has whole percents
    return _translated(_VALUES_TO_2.get(field), value)


def _translated(values: Names | None, value: Any) -> Any:
    if values is None:
        return value
    if isinstance(value, list):
        return [values.get(one, one) if isinstance(one, str) else one for one in value]
    return values.get(value, value) if isinstance(value, str) else value


def _without(message: Any, fields: frozenset[str]) -> Any:
    """Return a tree without some fields."""
    if isinstance(message, list):
        return [_without(one, fields) for one in message]
    if not isinstance(message, dict):
        return message
    return {
        key: value if key in ARBITRARY else _without(value, fields)
        for key, value in message.items()
        if key not in fields
    }

"""Spelling of messages in 2.x and 3.0: fields and values that have other names, and fields that one of them lacks.

Messages are trees of dicts and lists here, as JSON has them. Values of action parameters are left alone.
"""

from collections.abc import Callable, Iterator, Mapping
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

LIMITATION, LIMITATIONS = (
    "limitation",
    {"DIRECTED": "directedLimitation", "BIDIRECTED": "bidirectedLimitation"},
)
"""Name of the limitation of a zone in the schema of 3.0.0; those by type are of its text, and of 3.0.1."""

KINEMATIC, KINEMATICS = "mobileRobotKinematic", "mobileRobotKinematics"
"""Name of the kinematics that the schema of 3.0.0 requires, and the one that it describes, as 3.0.1 does."""

WHOLE = frozenset({"headerId", "sequenceId", "orderUpdateId", "lastNodeSequenceId", "degree", "referenceStateHeaderId"})
"""Fields with whole numbers, which some peers write as ``1.0``."""

ARBITRARY = frozenset({"value", "loadSpecification", "mobileRobotConfiguration", "envelopes3d"})
"""Fields whose values pass as they are: parameters of actions, and fields that this project does not interpret."""

Rules = Mapping[str, Callable[[Any], Any]]
"""Values of fields, by the names that the fields had."""


def from_version_2(topic: str, message: Tree) -> Tree:
    """Return a message of 2.x with the names and values of 3.0."""
    spelled: Tree = _spelled(message, NAMES_2.get(topic, {}), _TO_3, frozenset())
    if topic == topics.STATE:
        spelled.setdefault("instantActionStates", [])
    if topic == topics.INSTANT_ACTIONS and topic in spelled:
        spelled.setdefault("actions", spelled[topic])  # as the text of 2.0 named them, and some peers do
    return spelled


def name_in_version_2(topic: str, field: str) -> str:
    """Return the name in 2.x of a field that has another one in 3.0."""
    return _REVERSED.get(topic, {}).get(field, field)


def from_version_3(topic: str, message: Tree) -> Tree:
    """Return a message of 3.0 with whole numbers that are ints, and the names of 3.0.1."""
    spelled: Tree = _spelled(message, {}, _WHOLE_ONLY, frozenset())
    if topic == topics.ZONE_SET:
        name_limitations(spelled.get(topic))
    elif topic == topics.FACTSHEET:
        specification = spelled.get("typeSpecification")
        if isinstance(specification, dict) and KINEMATIC in specification:
            specification.setdefault(KINEMATICS, specification[KINEMATIC])
    return spelled


def name_limitations(zone_set: Any) -> None:
    """Give the limitations of zones the names of the text of 3.0 if they follow the schema of 3.0.0, in place."""
    for zone, name in _limited(zone_set):
        if zone.get(LIMITATION) is not None:
            zone.setdefault(name, zone[LIMITATION])


def _limited(zone_set: Any) -> Iterator[tuple[Tree, str]]:
    """Yield the zones whose type has a limitation, with its name in the text of 3.0."""
    zones = zone_set.get("zones") if isinstance(zone_set, dict) else None
    for zone in zones if isinstance(zones, list) else ():
        if isinstance(zone, dict) and (name := LIMITATIONS.get(str(zone.get("zoneType")))):
            yield zone, name


def to_version_2(topic: str, message: Tree) -> Tree:
    """Return a message with the names and values of 2.x, without fields that 3.0 alone has."""
    dropped = _ONLY_3_FIELDS.get(topic, frozenset())
    spelled: Tree = _spelled(message, _REVERSED.get(topic, {}), _TO_2, dropped)
    if topic == topics.STATE:
        spelled["actionStates"] = [*spelled["actionStates"], *spelled.pop("instantActionStates")]
    return spelled


def to_version_3(topic: str, message: Tree) -> Tree:
    """Return a message without the fields that 2.x alone has.

    Fields whose names differ between the schemas of 3.0.0 and 3.0.1 have both.
    """
    if topic == topics.ZONE_SET:
        for zone, name in _limited(message[topic]):
            if name in zone:
                zone[LIMITATION] = zone[name]
    elif topic == topics.FACTSHEET:
        specification = message.get("typeSpecification")
        if specification is not None:
            specification[KINEMATIC] = specification[KINEMATICS]
    dropped = _ONLY_2_FIELDS.get(topic)
    return message if dropped is None else _spelled(message, {}, {}, dropped)


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


def _spelled(message: Any, names: Names, rules: Rules, dropped: frozenset[str]) -> Any:
    """Return a tree with other names and values of its fields, without those that are dropped."""
    if isinstance(message, list):
        return [_spelled(one, names, rules, dropped) if isinstance(one, dict | list) else one for one in message]
    spelled = {}
    for key, value in message.items():
        if key in dropped:
            continue
        made = rules[key](value) if key in rules else value
        if isinstance(made, dict | list) and key not in ARBITRARY:
            made = _spelled(made, names, rules, dropped)
        spelled[names.get(key, key)] = made
    return spelled


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _circle(value: Any) -> Any:
    """Return a radius as the ellipse that 3.0 has."""
    is_radius = isinstance(value, int | float) and not isinstance(value, bool)
    return {"a": value, "b": value, "theta": 0.0} if is_radius else value


def _radius(value: Tree) -> float:
    """Return the radius of the largest circle in an ellipse."""
    return float(min(value["a"], value["b"]))


def _translation(values: Names) -> Callable[[Any], Any]:
    """Return the rule that replaces values, also in a list."""

    def translated(value: Any) -> Any:
        if isinstance(value, list):
            return [values.get(one, one) if isinstance(one, str) else one for one in value]
        return values.get(value, value) if isinstance(value, str) else value

    return translated


_WHOLE_ONLY: Rules = dict.fromkeys(WHOLE, _whole)
_TO_3: Rules = {
    **_WHOLE_ONLY,
    **{field: _translation(values) for field, values in VALUES_2.items()},
    **{old: _translation(VALUES_2[new]) for names in NAMES_2.values() for old, new in names.items() if new in VALUES_2},
    "allowedDeviationXY": _circle,
}
_TO_2: Rules = {
    **{field: _translation(values) for field, values in _VALUES_TO_2.items()},
    "allowedDeviationXY": _radius,
    "batteryHealth": round,  # 2.0 has whole percents
}

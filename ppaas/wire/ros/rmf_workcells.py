"""Definitions of ``rmf_dispenser_msgs`` and ``rmf_ingestor_msgs``, by which Open-RMF and workcells speak.

Source: ``open-rmf/rmf_internal_msgs`` since version 3, which is the same in all releases of ROS 2.
"""

from typing import Final

DISPENSER_REQUEST: Final = "rmf_dispenser_msgs/msg/DispenserRequest"
DISPENSER_RESULT: Final = "rmf_dispenser_msgs/msg/DispenserResult"
INGESTOR_REQUEST: Final = "rmf_ingestor_msgs/msg/IngestorRequest"
INGESTOR_RESULT: Final = "rmf_ingestor_msgs/msg/IngestorResult"

_ITEM = """
        string type_guid
        int32 quantity
        string compartment_name
    """
_RESULT = """
        builtin_interfaces/Time time
        string request_guid
        string source_guid
        uint8 status
        uint8 ACKNOWLEDGED=0
        uint8 SUCCESS=1
        uint8 FAILED=2
    """
_REQUEST = """
        builtin_interfaces/Time time
        string request_guid
        string target_guid
        string transporter_type
    """

WORKCELLS: Final = {
    "rmf_dispenser_msgs/msg/DispenserRequestItem": _ITEM,
    "rmf_ingestor_msgs/msg/IngestorRequestItem": _ITEM,
    DISPENSER_REQUEST: _REQUEST + "    rmf_dispenser_msgs/DispenserRequestItem[] items\n",
    INGESTOR_REQUEST: _REQUEST + "    rmf_ingestor_msgs/IngestorRequestItem[] items\n",
    DISPENSER_RESULT: _RESULT,
    INGESTOR_RESULT: _RESULT,
}

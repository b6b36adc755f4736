"""Services of a clone by the right that they need: some only read, and some configure the robot."""

from ppaas.wire import rosapi

READING = frozenset(
    {
        "compute_costs",
        "compute_fleet_plan",
        "compute_packed_path",
        "compute_path",
        "dynamic_map",
        "keepout_filter_mask",
        "make_plan",
        "map_zones",
        "move_base/compute_path",
        "move_base/make_plan",
        "node_monitor/list_nodes",
        "octomap_binary",
        "octomap_full",
        "octomap_server/file",
        "people_coordinator/get_people",
        "people_coordinator/get_people_counts",
        "pose_graph",
        "recorder/state",
        "rosapi/get_param",
        "rosapi/get_param_names",
        "rosapi/has_param",
        "rosapi/search_param",
        "speed_filter_mask",
        "static_map",
        "traffic/get_traffic",
    }
)
"""Services that change nothing of the robot and its clone."""

PASSED_ON = {"tf2_web_republisher": "tf", "republish_tfs": "tf"}
"""Actions and services whose feedback or stream has the content of a topic."""

CONFIGURING = frozenset(
    {
        "node_monitor/give_node",
        "node_monitor/hold_node",
        "node_monitor/run_node",
        "node_monitor/tell_robot",
        "people_coordinator/configure_people",
        "rosapi/delete_param",
        "rosapi/set_param",
        "traffic/put_back",
        "traffic/take_out",
    }
)
"""Services that change what the clone consists of, its parameters, or what its group does."""


def lists_names(service: str) -> bool:
    """Return whether a service only lists names and types of the graph, which all clients of a robot may see."""
    return service in rosapi.SERVICES


def only_reads(service: str) -> bool:
    """Return whether a service changes nothing."""
    return service in READING


def passed_on(name: str) -> str:
    """Return the topic whose content an action or a service passes on; empty if there is none."""
    return PASSED_ON.get(name, "")


def configures(service: str) -> bool:
    """Return whether a service configures the clone of a robot."""
    return service in CONFIGURING

"""Definitions of Nav2's actions for docks, as the text of their files, by release.

Sources: ``opennav_docking_msgs`` of ``open-navigation/opennav_docking``, which Humble has, and ``nav2_msgs`` of
``ros-navigation/navigation2``.
"""

from typing import Final


def _actions(package: str, error: str) -> dict[str, str]:
    """Return both actions of a package, given the last field of their results."""
    return {
        f"{package}/action/DockRobot": f"""
            bool use_dock_id true
            string dock_id
            geometry_msgs/PoseStamped dock_pose
            string dock_type
            float32 max_staging_time 1000.0
            bool navigate_to_staging_pose true
            ---
            bool success true
            uint16 error_code 0
            uint16 num_retries 0
            {error}
            ---
            uint16 state
            builtin_interfaces/Duration docking_time
            uint16 num_retries 0
        """,
        f"{package}/action/UndockRobot": f"""
            string dock_type
            float32 max_undocking_time 30.0
            ---
            bool success true
            uint16 error_code 0
            {error}
            ---
        """,
    }


HUMBLE: Final = _actions("opennav_docking_msgs", "")
SINCE_JAZZY: Final = _actions("nav2_msgs", "string error_msg")

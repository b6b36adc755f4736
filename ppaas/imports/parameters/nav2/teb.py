"""Parameters of the controller plug-in TEB."""

from ppaas.imports.parameters import elastic_band
from ppaas.imports.parameters.nav2.reasons import SIDEWAYS, TOLERANCES, TRANSFORMS
from ppaas.imports.parameters.nav2.tables import PluginTable
from ppaas.imports.parameters.rules import without_effect

TEB = PluginTable(
    "teb_local_planner::TebLocalPlannerROS",
    {
        **elastic_band.RULES,
        **without_effect(TOLERANCES, "xy_goal_tolerance yaw_goal_tolerance trans_stopped_vel theta_stopped_vel"),
        **without_effect(SIDEWAYS, "max_vel_trans"),
        **without_effect("the clone has the odometry and the frames of its robot", "odom_topic map_frame"),
        **without_effect(TRANSFORMS, "transform_tolerance"),
    },
    becomes="mppi",
)

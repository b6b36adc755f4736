"""Rules for the local planners of ROS 1: trajectory rollout and the dynamic window become dwa, elastic bands mppi."""

from ppaas.imports.parameters import elastic_band
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, renamed, same, without_effect
from ppaas.imports.parameters.values import FINEST_OF_MPPI, at_least

_DWA, _MPPI = "parameters.dwa.", "parameters.mppi."

_SIDEWAYS = "robots do not drive sideways here"
_DEBUG = "it is for debugging"
_RECONFIGURE = "it belongs to dynamic_reconfigure"
_STUCK = "a robot that is stuck recovers by move_base's recovery behaviours"
_ESCAPE = "the recovery behaviour back_up backs up"
_WEIGHTS = "weights of dwa have other units: those of dwa hold"
_CHECKED = "outlines are checked between the steps by their distance to obstacles"
_STOPS = "a robot can always stop before what its rollout touches"
_PRUNED = "the part of the plan behind the robot is never followed"
_LATCHED = "a robot at its goal turns in place, and does not come back for its position"
_TOPICS = "the topics are those of the robot: 'scan' and 'odom'"
_CYCLE = "it runs at move_base's controller_frequency"


TRAJECTORY: ParameterRules = {
    **same(
        _DWA, "max_vel_x", "min_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "xy_goal_tolerance",
        "yaw_goal_tolerance", "sim_time", "sim_granularity", "vx_samples",
    ),
    **renamed(
        _DWA, max_rotational_vel="max_vel_theta", acc_lim_th="acc_lim_theta", vtheta_samples="vth_samples",
        min_in_place_vel_theta="min_vel_theta", min_in_place_rotational_vel="min_vel_theta",
        rot_stopped_velocity="rot_stopped_vel", trans_stopped_velocity="trans_stopped_vel",
    ),
    "min_vel_theta": ParameterRule(text="turns to the right are as fast as those to the left"),
    **without_effect(
        _SIDEWAYS, "holonomic_robot", "y_vels", "acc_lim_y", "max_vel_y", "min_vel_y", "vy_samples", "strafe_in_place",
    ),
    **without_effect(_ESCAPE, "escape_vel", "backup_vel", "escape_reset_dist", "escape_reset_theta"),
    **without_effect(
        _WEIGHTS, "pdist_scale", "gdist_scale", "path_distance_bias", "goal_distance_bias", "occdist_scale",
        "meter_scoring",
    ),
    **without_effect(
        "rollouts are scored along the whole way", "heading_lookahead", "heading_scoring", "heading_scoring_timestep",
        "simple_attractor",
    ),
    **without_effect(_STUCK, "oscillation_reset_dist"),
    **without_effect(_CHECKED, "angular_sim_granularity", "world_model", "inscribed_radius", "circumscribed_radius"),
    **without_effect(_STOPS, "stop_time_buffer"),
    **without_effect(_PRUNED, "prune_plan"),
    **without_effect(_LATCHED, "latch_xy_goal_tolerance", "final_goal_distance_bias"),
    **without_effect(_CYCLE, "sim_period", "controller_frequency"),
    **without_effect(_DEBUG, "publish_cost_grid_pc", "publish_cost_grid", "publish_traj_pc"),
    **without_effect("xy_goal_tolerance is the distance to the goal", "x_goal_tolerance", "y_goal_tolerance"),
    **without_effect("frames are named in amcl or grid_slam", "global_frame_id", "odom_topic"),
    "dwa": ParameterRule(text="dwa always searches the velocities of the next cycle"),
    "point_grid": ParameterRule(text="obstacles are the cells of the local costmap"),
    **without_effect(
        "move_base does not read it: its names are acc_lim_x, acc_lim_th", "acc_limit_x", "acc_limit_y", "acc_limit_th",
    ),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}  # fmt: skip
"""Rules of base_local_planner/TrajectoryPlannerROS."""

DYNAMIC_WINDOW: ParameterRules = {
    **same(
        _DWA, "max_vel_x", "min_vel_x", "min_vel_trans", "max_vel_theta", "min_vel_theta", "acc_lim_x",
        "acc_lim_theta", "xy_goal_tolerance", "yaw_goal_tolerance", "trans_stopped_vel", "rot_stopped_vel", "sim_time",
        "sim_granularity", "vx_samples", "vth_samples", "path_distance_bias", "goal_distance_bias", "occdist_scale",
        "forward_point_distance",
    ),
    **renamed(
        _DWA, min_trans_vel="min_vel_trans", max_rot_vel="max_vel_theta", min_rot_vel="min_vel_theta",
        acc_lim_th="acc_lim_theta", theta_stopped_vel="rot_stopped_vel", vtheta_samples="vth_samples",
    ),
    **without_effect("acc_lim_x bounds the acceleration", "acc_lim_trans", "acc_limit_trans"),
    **without_effect(_SIDEWAYS, "max_vel_y", "min_vel_y", "acc_lim_y", "vy_samples", "holonomic_robot", "holonomic"),
    **without_effect(_STUCK, "oscillation_reset_dist", "oscillation_reset_angle"),
    **without_effect("cost_slowdown of dwa slows a robot down near obstacles", "scaling_speed", "max_scaling_factor"),
    **without_effect("rollouts that turn need no less than those that do not", "twirling_scale", "penalize_negative_x"),
    **without_effect(_CHECKED, "angular_sim_granularity", "angular_granularity"),
    **without_effect(_STOPS, "stop_time_buffer"),
    **without_effect(_PRUNED, "prune_plan"),
    **without_effect(_LATCHED, "latch_xy_goal_tolerance"),
    **without_effect(_CYCLE, "sim_period", "controller_frequency"),
    **without_effect(_DEBUG, "publish_traj_pc", "publish_cost_grid_pc", "publish_cost_grid"),
    **without_effect("frames are named in amcl or grid_slam", "global_frame_id", "odom_topic"),
    "cheat_factor": ParameterRule(text=_WEIGHTS),
    "inner_xy_goal_tolerance": ParameterRule(text="xy_goal_tolerance is the distance to the goal"),
    "use_dwa": ParameterRule(text="dwa always searches the velocities of the next cycle"),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}  # fmt: skip
"""Rules of dwa_local_planner/DWAPlannerROS, of which releases before Jade have other names."""

ELASTIC_BAND: ParameterRules = {
    **elastic_band.RULES,
    **same(_MPPI, "yaw_goal_tolerance", "trans_stopped_vel"),
    **renamed(_MPPI, theta_stopped_vel="rot_stopped_vel"),
    "xy_goal_tolerance": ParameterRule(
        _MPPI + "xy_goal_tolerance",
        f"at least {FINEST_OF_MPPI}: mppi does not come to rest nearer to a goal",
        at_least(FINEST_OF_MPPI),
    ),
    **without_effect(_TOPICS, "odom_topic", "map_frame"),
    "transform_tolerance": ParameterRule(text="scans may be as old as move_base's transform_tolerance"),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}
"""Rules of teb_local_planner/TebLocalPlannerROS."""

TOP_SPEEDS = ("max_vel_trans", "max_trans_vel")
"""Parameters that bound ``max_vel_x``; of a robot that does not drive sideways, the lower one is its top speed."""

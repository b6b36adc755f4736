-- The same robot, with cartographer.
include "map_builder.lua"
include "trajectory_builder.lua"

options = {
  map_builder = MAP_BUILDER,
  trajectory_builder = TRAJECTORY_BUILDER,
  map_frame = "map",
  tracking_frame = "base_link",
  published_frame = "odom",
  provide_odom_frame = false,
  submap_publish_period_sec = 2.,
}

MAP_BUILDER.use_trajectory_builder_2d = true
TRAJECTORY_BUILDER_2D.max_range = 12.
TRAJECTORY_BUILDER_2D.motion_filter.max_distance_meters = 0.3
TRAJECTORY_BUILDER_2D.motion_filter.max_angle_radians = math.rad(17.)

return options

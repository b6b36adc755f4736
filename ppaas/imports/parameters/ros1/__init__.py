"""Parameter files of ROS 1: move_base, its costmaps, planners and recovery behaviours."""

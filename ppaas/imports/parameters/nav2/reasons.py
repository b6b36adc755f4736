"""Reasons why parameters of controllers have no effect."""

TOLERANCES = "the tolerances of the goal checker count"
SIDEWAYS = "the clone does not drive sideways"
BRAKES = "the base brakes as it accelerates"
SHOWN = "nothing is published to look at"
WHOLE_PATH = "the whole path is followed, and pruned by where the robot is"
TRANSFORMS = "move_base.transform_tolerance holds for all transforms"
OTHER_COSTS = "the costs of mppi are seconds of travel time, with their own weights"

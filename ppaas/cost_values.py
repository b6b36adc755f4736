"""Cost values of cells that have a meaning of their own, as in costmap_2d; all between them are graded costs."""

FREE_SPACE = 0
INSCRIBED_INFLATED_OBSTACLE = 253
LETHAL_OBSTACLE = 254
NO_INFORMATION = 255

"""Special cost values of costmap cells, as in costmap_2d. Values from 1 to 252 are graded costs."""

FREE_SPACE = 0
INSCRIBED_INFLATED_OBSTACLE = 253
LETHAL_OBSTACLE = 254
NO_INFORMATION = 255

"""REST resources of planning: paths, cost matrices, planners, and the Path Plan Database."""

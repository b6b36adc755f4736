"""Files of a comparison: those of the map, and the pose graph of the robot that continues it."""

from storage.versions import IMAGE, POSEGRAPH, YAML

BEFORE = "before-"
"""Prefix of the files of the map; the pose graph of the robot is named as the part of a map."""

PARTS = (YAML, IMAGE, POSEGRAPH)
"""Files of the map that are compared."""

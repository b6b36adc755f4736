"""Files of a comparison: the map's files, the pose graph of the robot that continues it, and the settings."""

from storage.versions import IMAGE, POSEGRAPH, YAML

BEFORE = "before-"
"""Prefix of the files of the map; the pose graph of the robot is named as the part of a map."""

PARTS = (YAML, IMAGE, POSEGRAPH)
"""Files of the map that are compared."""

SETTINGS = "settings.json"
"""Known changes and thresholds of the drawing; too many for arguments of a program."""

"""Mapping of an unknown place, as gmapping and slam_toolbox do it."""

"""Buildings of other programs: all floors at once, with their maps."""

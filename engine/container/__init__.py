"""Container: the process of a clone, or of planning on a map, with its robot link and machine link."""

"""Hub labels: an index of a map, made once, from which shortest paths are read off in microseconds."""

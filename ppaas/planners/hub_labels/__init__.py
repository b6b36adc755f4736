"""Hub labels: an index of a map, built once, that answers path queries in microseconds (Abraham et al., 2011)."""

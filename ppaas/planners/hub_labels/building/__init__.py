"""Building and repair of the index of hub labels."""

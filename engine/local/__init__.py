"""TODO engine/local."""

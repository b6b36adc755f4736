"""TODO engine/runtimes/docker."""

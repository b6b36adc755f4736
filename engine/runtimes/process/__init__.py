"""TODO engine/runtimes/process."""

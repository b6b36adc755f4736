"""TODO engine/runtimes/compilation."""

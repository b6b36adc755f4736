"""TODO engine/container/warm_up."""

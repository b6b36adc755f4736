"""TODO engine/runtimes/memory_tuning."""

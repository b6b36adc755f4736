"""TODO engine/runtimes/fork_server."""

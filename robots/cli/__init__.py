"""TODO robots/cli."""

"""The engine: a master that decides, machines that carry, containers with clones inside."""

"""Docker runtime: containers run by the Docker Engine."""

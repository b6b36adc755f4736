"""Stores behind ports: users, maps, robots, plans and clones, opened by URL."""

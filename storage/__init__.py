"""Stores of users, maps, robots, plans and clones: ports, records, and the backends that implement them."""

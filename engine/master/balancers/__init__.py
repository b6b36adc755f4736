"""Balancers: which machine a container is placed on."""

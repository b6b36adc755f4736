"""Balancers: plug-ins that choose the machine a container is placed on."""

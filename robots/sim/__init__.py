"""Simulated robots: a world made of a map, Turtlebots in it, and what their sensors tell. Needs ``ppaas[sim]``.

The true pose never leaves this room: what a simulated robot publishes is made by its sensors alone.
"""

"""Simulation of Turtlebots and people in a map. Needs the extra ``sim``.

The true pose is never published: a simulated robot publishes only the output of its sensors.
"""

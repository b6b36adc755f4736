"""Robots that speak the protocol of Rapyuta, the RoboEarth Cloud Engine: a port of their own, and clients of places.

A robot's containers are views of its clone: an interface in one of them is a topic or a service of the clone. The
session at the place is that of any client (`engine.sessions.session`), so rights, quotas and limits are the same.
"""

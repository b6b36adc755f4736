"""Robots that speak the protocol of Rapyuta, the RoboEarth Cloud Engine: a separate port, and clients of places.

A robot's containers are views of its clone: an interface in one of them is a topic or a service of the clone. The
session at the place is the same as any client's (`engine.sessions.session`), so rights, quotas and limits are the same.
"""

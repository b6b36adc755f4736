"""Ray machines: Ray reports the nodes of its cluster and runs an agent on each.

No message of a robot or of the master passes through Ray.
"""

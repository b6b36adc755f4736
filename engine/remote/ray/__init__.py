"""Ray machines: nodes of a Ray cluster, which tells what nodes there are and runs an agent on each.

No message of a robot or of the master goes through Ray.
"""

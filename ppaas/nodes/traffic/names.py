"""Names of traffic, for those who do not load the node."""

TRAFFIC = "traffic"
"""Name of the node, and of the parameters of the robots that take part in traffic."""

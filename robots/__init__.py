"""Robot side: clients of a cloud, programs for the robot's computer, simulated robots, and the command line ``ppaas``.

The modules directly in this package are aliases of earlier import paths.
"""

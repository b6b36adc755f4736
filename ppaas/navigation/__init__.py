"""Navigation: Move Base as a state machine without I/O; events go in, orders come out."""

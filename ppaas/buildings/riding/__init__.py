"""Rides in lifts: where a robot is in the car meanwhile, on which floor it leaves, and where it is there."""

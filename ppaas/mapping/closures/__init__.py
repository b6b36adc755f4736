"""Loop closures: an area that the robot sees again is found, checked, and tied to its first visit."""

"""Transport of robots with rmw_zenoh, on ``eclipse-zenoh``."""

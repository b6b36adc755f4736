"""Tasks of the robots of a user on a map, led by the process of the master."""

"""Node ``explore``: drives a robot that makes a map to frontiers until none is left."""

"""Pipeline of mapping: tracking, loop closures and the pose graph together, and maps of logs."""

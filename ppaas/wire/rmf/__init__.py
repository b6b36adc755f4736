"""Driver of a fleet of Open-RMF without I/O: robots that follow its paths, and the frame of its maps."""

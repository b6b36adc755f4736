"""Service: executes the master's orders, feeds it events, and answers what the endpoints ask of the engine."""

"""Service: executes the master's orders, feeds it events, and answers the requests of the endpoints."""

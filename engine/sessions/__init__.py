"""Sessions of the clients of a place: subscriptions, calls, goals, and the frames that wait for a client."""

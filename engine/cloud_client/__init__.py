"""The engine in an endpoint process: a client of the cloud's master and of the containers of places."""

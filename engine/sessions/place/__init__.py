"""A place, as its clients share it: topics, services and actions of the clone and of the clients."""

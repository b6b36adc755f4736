"""Rights of clients on a robot: what they may publish, subscribe to and call."""

"""Base classes of messages, and ``std_msgs``, on which all other messages build."""

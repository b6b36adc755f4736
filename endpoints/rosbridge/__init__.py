"""TODO endpoints/rosbridge."""

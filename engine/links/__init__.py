"""Both ends of the robot link: the clients of a place, their subscriptions and open calls."""

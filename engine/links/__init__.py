"""What is the same at both ends of the robot link: clients of a place, their subscriptions and open calls."""

"""Messages of single actions of Nav2: its behaviors, and FollowPath."""

"""Path planning for programs: requests, their rate, and their way to a planning container."""

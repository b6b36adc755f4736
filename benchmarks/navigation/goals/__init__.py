"""A robot that is sent to goals among people who walk about: how many it comes to, and whom and what it touches."""

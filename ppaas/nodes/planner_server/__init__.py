"""Node ``planner_server``: plans paths, and costs of paths, when asked."""

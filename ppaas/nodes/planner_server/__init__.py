"""Node ``planner_server``: plans paths and computes cost matrices on request."""

"""Dashboard: web pages that use the REST service and the robot WebSocket like any other client."""

"""Network interface of the cloud: the robot WebSocket (rosbridge), the REST service, and the commands that start it."""

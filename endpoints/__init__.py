"""What the cloud shows: the robot WebSocket, REST and the command line."""

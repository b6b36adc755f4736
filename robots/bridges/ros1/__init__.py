"""Transport of robots with ROS 1: TCPROS, and the XML-RPC of the master and of nodes."""

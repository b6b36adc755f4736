"""Fork server: loads once what containers use, and forks each container from that."""

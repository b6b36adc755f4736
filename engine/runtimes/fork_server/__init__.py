"""Fork server: imports once the modules of containers, and forks each container from that process."""

"""Fleet of robots of the cloud for Open-RMF, by the messages ``rmf_fleet_msgs``."""

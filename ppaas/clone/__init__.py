"""Clone of a robot: which nodes act for it in the cloud, with which parameters for its body."""

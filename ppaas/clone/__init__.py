"""Clone of a robot: creates its nodes and plug-ins, with parameters that suit its body."""

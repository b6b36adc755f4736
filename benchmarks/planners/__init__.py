"""How fast planners plan and how right they are, measured without a cloud but for the paper's Fig. 3."""

"""Server of the Model Context Protocol (MCP): programs with a language model look at robots, and drive them."""

"""Motion: joint-space path pieces with their time law, and the samples along them."""

"""The methods that the search is compared with: every instant, and the seed paper's."""

"""The path kernel of Li and Leung (paper 2.2.1), exact and fast."""

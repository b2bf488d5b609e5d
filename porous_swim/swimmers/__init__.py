"""Where swimmers start."""

"""Values in, values out: the laws that move one swimmer near one colloid."""

"""How fast the engine is, in ratios: to C that does the same job, and to itself under other conditions."""

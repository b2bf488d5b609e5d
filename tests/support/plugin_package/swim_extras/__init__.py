"""Parts for porous_swim that are not its own."""

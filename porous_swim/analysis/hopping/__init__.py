"""Hops between colloids, and their network."""

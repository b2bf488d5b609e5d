"""Runs: a scene goes in, results come out."""

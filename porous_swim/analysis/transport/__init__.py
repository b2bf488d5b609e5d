"""Displacements, directors and diffusivities."""

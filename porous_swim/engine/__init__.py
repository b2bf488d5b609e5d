"""The only place with device memory, loops and `ti.init`."""

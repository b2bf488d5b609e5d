"""The kernel: blocks of lanes that advance swimmers, and the scalar pass that handles their events."""

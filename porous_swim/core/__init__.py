"""What everything else stands on: errors, models of parts, console, random streams."""

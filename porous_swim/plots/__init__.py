"""Pictures of what `analysis` finds, one module for each: data in, a `matplotlib.figure.Figure` out.

No picture touches pyplot or needs a display. Lengths in a, times in a/U; where `Scales` know what these are in the
laboratory, a second axis says so. Each `draw` takes runs to lay over each other, or side by side where they would hide
each other.
"""

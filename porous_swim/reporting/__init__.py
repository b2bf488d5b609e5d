"""Reports of runs: one page of HTML that needs nothing else, and its pictures. One module for each section.

`write.SECTIONS` is the one list of them. A section takes runs and returns what to show; it says in a sentence what it
cannot show and why.
"""

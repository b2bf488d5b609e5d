"""Censored times: survival, means, fits, comparisons."""

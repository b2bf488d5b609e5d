"""The colloids: layouts that place them, the field that holds them, and the search among them."""

"""How positions depend on what a linkage is made of."""

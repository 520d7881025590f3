"""How far clearances and tolerances let a point go at most."""

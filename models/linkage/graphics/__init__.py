"""Figures, pictures, movies and CAD drawings of a linkage and its motion."""

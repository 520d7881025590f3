"""Members in scikit-fem: a line mesh in space, forms, and matrices of one member by quadrature."""

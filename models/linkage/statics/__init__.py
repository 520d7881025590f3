"""Forces and compliance of a moving linkage: reactions, transmission, frame, stiffness, accuracy."""

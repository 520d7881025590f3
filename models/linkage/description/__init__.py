"""What a linkage is made of, and the checks of what the user says of it."""

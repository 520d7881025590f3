"""What a frame is made of: its parts, and the classes of its description by subject."""

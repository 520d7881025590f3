"""The description of a frame, by subject: nodes and bodies, members and joints, supports, loads."""

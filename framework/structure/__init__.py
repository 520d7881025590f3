"""From a description to equations: numbering, stacks of members, joint-relative coordinates, stiffness and loads."""

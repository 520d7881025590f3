"""Where linear results break: true error and stated bound along the axes of what is hard."""

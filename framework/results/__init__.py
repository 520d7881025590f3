"""What is read off a solution: forces, fields, status, condition, vibration and buckling."""

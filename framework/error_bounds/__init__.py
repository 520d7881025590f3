"""How far computed results are from exact ones, and how they depend on every input."""

"""The broadcasting way: a plan compiled once, an elimination whose numbers are arrays."""

"""Run time and error of linkframe, beside the programs that people use today: ``python tests/benchmarks/run.py``."""

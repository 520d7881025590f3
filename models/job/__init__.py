"""What the jobs of the command line share: stages, output folder, tables, figures."""

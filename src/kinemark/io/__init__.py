"""Files: one module a format. Units become mm, s and px here, and nowhere else."""

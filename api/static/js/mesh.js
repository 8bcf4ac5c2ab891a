// Slope, mesh and displacements of a job.

// The statistics of a job.

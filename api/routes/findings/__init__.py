"""What the evaluations of a job tell: fit, points, statistics, uncertainty, fields. Nothing here is kept."""

// Workers and operations.

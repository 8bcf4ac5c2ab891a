"""What is read from and written to the tables; all take the connection of the caller's transaction."""

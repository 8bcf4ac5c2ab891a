"""What one client could do to the others."""

"""What is found wrong, or worth telling, in a problem that can be read."""

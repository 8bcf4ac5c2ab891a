"""What becomes of the readings of an observation: blocks joined, processed, and which of them take part."""

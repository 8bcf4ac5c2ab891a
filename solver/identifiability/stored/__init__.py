"""Statistics of stored evaluations, and what follows from them."""

"""Evaluations that search methods need: ours, the textbook swarm and published libraries, on the same problems."""

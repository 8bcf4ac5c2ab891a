"""Finite elements: six-node triangles and interfaces under phases of loading and creep, tension positive."""

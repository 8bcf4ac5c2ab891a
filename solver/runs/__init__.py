"""Runs in process: the loop of a calibration, its processes, its journal, and a try before."""

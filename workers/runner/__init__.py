"""Runs forward calculations in a process that can be killed, with everything that it starts.

==============  ===========================================================================================
``evaluator``   what evaluates for a worker, and its limits
``runner``      a worker's side: hands out positions, watches limits, kills
``nurse``       a small process that forks evaluation processes from a warm state; nothing outlives it
``child``       the evaluation process
``wire``        what goes over the sockets between them: JSON and float64, no pickle
``processes``   process trees and their memory
==============  ===========================================================================================
"""

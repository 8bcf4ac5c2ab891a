"""Runs forward calculations in a process that can be killed, with everything that it starts.

==============  ===========================================================================================
``runner``      a worker's side: hands out positions, watches limits, kills
``nurse``       a small process that forks the evaluation processes from a warm state, and sees that nothing outlives them
``child``       the evaluation process
``wire``        what goes over the sockets between them: JSON and float64, no pickle
``processes``   process trees and their memory
==============  ===========================================================================================
"""

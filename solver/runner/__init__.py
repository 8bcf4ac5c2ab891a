"""Runs forward calculations in a process that can be killed, with everything that it starts.

===============  ===========================================================================================
``evaluator``    what evaluates for a worker, and its limits
``runner``       a worker's side: hands out positions, watches limits, kills
``process``      a worker's side of one evaluation process: asks it, takes in answers
``nurse_link``   a worker's side of the nurse: has her fork, load and kill
``nurse``        a small process that forks evaluation processes from a warm state; nothing outlives it
``child``        the evaluation process
``traces``       what a run has left in it
``wire``         what goes over the socket between them: frames of JSON and float64, no pickle
``board``        the memory that they share: what is being evaluated, since when
``kernels``      has the kernels of a problem compiled and loaded before it begins
``output``       the file that takes what forward models write
``environment``  what forward models see of the environment
``processes``    process trees and their memory
``team``         runners that share a calibration in process
===============  ===========================================================================================
"""

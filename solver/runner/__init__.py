"""Runs forward calculations in a process that can be killed, with everything that it starts.

====================  ==========================================================================
``evaluator``         what evaluates positions for a worker, and the limits that it keeps
``runner``            hands out positions to a process, kills what exceeds a limit
``team``              runners that share the evaluations of a calibration in process
``kernels``           has kernels compiled before a job begins
``fork_server``       forks evaluation processes from a warm state; ``fork_server_link`` asks it
``child``             the evaluation process; ``process`` is the worker's side of it
``wire``              frames between the two; ``shared_state`` memory that they share
``fields``            a run for the fields of a body
``output``            takes what forward models print
``traces``            what a run has left in its process
====================  ==========================================================================
"""

"""Runs forward calculations in a process that can be killed, with everything that it starts.

====================  ==================================================================================================
``evaluator``         what evaluates positions for a worker, and the limits that it keeps; fields of a body
``runner``            hands out positions to a process, kills what exceeds a limit
``team``              runners that share the evaluations of a calibration in process
``kernels``           has kernels compiled before a job begins
``fork_server``       forks evaluation processes from a warm state; ``fork_server_link`` asks it
``child``             the evaluation process; ``process`` is the worker's side of it
``wire``              frames between the two; ``shared_state`` memory that they share
``output``            takes what forward models print
``traces``            what a run has left in its process
``fork_server_link``  a worker's side of the fork server: starts it, has it fork, load and kill, and replaces it when it
                      is lost
``isolated``          stand-ins for forward models of other packages, which are read, built and asked in a process apart
``isolated_host``     the process in which forward models of other packages are read, built and asked; see
                      :mod:`.isolated`
``process``           a worker's side of one evaluation process: asks it, and takes in answers without ever waiting for
                      it alone
``shared_state``      memory that a worker and its evaluation process share
====================  ==================================================================================================
"""

"""Runs in process.

==============  ====================================================================================================
``local``       the loop of a calibration, the reference for the distributed engine
``evaluators``  what evaluates its generations: this process or others
``journal``     what is kept of a run, so that another goes on with it
``runlog``      the runs of a job as a search that learns from them sees them
``warm_start``  evaluations of earlier calibrations, offered to a new one
``check``       a try before a problem becomes a job
``synthetic``   readings that a model gives, to try a calibration
``under_way``   generations in progress in this process; nothing is run twice, including what an interrupted run has
                kept
==============  ====================================================================================================
"""

"""Commands that calculate here, or read what was calculated here.

==============  =====================================================================================================
``check``       ``geoswarm check``: validate a problem, run it once and estimate its cost
``estimate``    ``geoswarm estimate``: first estimates from the readings with a ruler, and from index properties
``evaluate``    ``geoswarm evaluate``: one forward calculation with given parameters
``findings``    ``geoswarm posterior``, and how findings about uncertainty are shown
``follow_ups``  ``geoswarm sensitivity``, ``profile``, ``explore``, ``influence``: further evaluations that tell how
                sure it is
``outlook``     ``geoswarm predict`` and ``design``: what comes next, with the uncertainty of what was identified
``reports``     ``geoswarm report``: the report of a job or of a run in a folder
``reweight``    ``geoswarm reweight``: stored evaluations under other weights
``run``         ``geoswarm run``: a calibration in this process, with figures and tables
``run_folder``  the folder of ``geoswarm run --output``: what is there, what is kept, how to go on
``running``     runs follow-ups: here, kept in the folder of the run, or as a job of a service that is waited for
``source``      where statistics and reports come from: a job of a service, or a folder of ``geoswarm run --output``
``statistics``  ``geoswarm statistics``: what the evaluations of a run tell about its parameters, and what to do next
==============  =====================================================================================================
"""

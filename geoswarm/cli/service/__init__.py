"""Commands for the jobs of a service.

===============  =====================================================================================================
``agent``        ``geoswarm agent``: a worker that needs nothing but the address of its service and a key
``attachments``  ``geoswarm attachments``: files of a job
``connection``   talks to a service for the commands about jobs
``export``       ``geoswarm export``: all evaluations of a job
``failures``     why evaluations failed, and another try: ``geoswarm show ID --failures``, ``--attempts`` and ``retry-
                 failed``
``hooks``        ``geoswarm hooks``: notifications of a service when a job has ended
``jobs``         ``geoswarm list``, ``show``, ``cancel``, ``pause``, ``resume`` and ``workers``
``keys``         ``geoswarm keys``: API keys, in the database itself, so that the first one needs none
``progress``     the progress bar of searches: on stderr, and only on a terminal
``prune``        ``geoswarm prune``: deletes old jobs for good
``submit``       ``geoswarm submit`` and ``watch``
===============  =====================================================================================================
"""

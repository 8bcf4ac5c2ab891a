# Generated from geoswarm/client/_async/__init__.py by scripts/generate_client.py; `make format` renews it.
"""The synchronous client.

==============  ===================================================================================
``client``      :class:`~geoswarm.client.Client`: all methods, as one table
``connection``  address, key, timeouts; sends one request and reads its answer
``jobs``        submit, find, steer and delete jobs
``following``   follow the events of a job, wait for its end
``attached``    files that are attached to a job: list, attach, download, delete
``results``     what a job has evaluated, its fit, and the bodies behind it
``analysis``    statistics and uncertainty of a job
``reports``     its reports and figures
``drafts``      problems before they are jobs: check, examples, files of measurements
``service``     forward models, workers, health, links, hooks, keys, operations
==============  ===================================================================================

The methods are plain functions: ``self`` is the connection, which is all that they need.
"""

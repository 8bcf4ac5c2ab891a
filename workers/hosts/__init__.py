"""Where workers live: embedded beside the API, or in Celery's processes.

===================  ===================================================================================================
``alone``            processes that run no workers: how they ring, and the one that only sweeps
``celery_app``       the Celery side: wake-ups over Redis, and worker processes that answer them
``celery_channel``   reads wake-ups from Redis; what is not a message of Celery is dropped instead of ending the worker
``embedded``         the embedded engine: worker processes on this machine, supervised, with a pipe as waker
``embedded_worker``  the main program of a worker process of the embedded engine
``engine``           opens the engine: a service for the API, with embedded workers or with wake-ups of Celery workers
``healthcheck``      ``python -m geoswarm.workers.hosts.healthcheck [--worker]``, for supervisors of containers: exit
                     code 0 or 1
``tasks``            what runs inside the pool processes of a Celery worker
===================  ===================================================================================================
"""

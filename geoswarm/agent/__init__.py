"""The agent: a worker without the database, behind ``geoswarm agent``. It reaches a service by HTTP and nothing else.

=============  =======================================================================================================
``agent``      starts, announces, waits for work, ends
``slot``       runs what a lease holds, and brings what came of it
``server``     speaks to the service; ``backoff`` says how long to wait before the next try
``inventory``  what runs on this machine
``fetched``    registered models that the service hands out, by hash
``outbox``     results on disk until the service has them
``runs``       makes runs in a process of its own and watches its limits; ``run_main`` is that process
``trees``      processes that end with all that they have started, by system
``spans``      until when an agent runs
``errors``     what can go wrong between an agent and its service
``run_main``   the process that makes runs for an agent: reads requests from standard input, line by line, and answers
=============  =======================================================================================================

Nothing here needs more than the base installation, or a module that only POSIX systems have.
"""

"""What the service can be asked."""

from __future__ import annotations

from geoswarm.client._async import analysis, attached, drafts, following, jobs, reports, results, service
from geoswarm.client._async.connection import AsyncConnection

__all__ = ["AsyncClient"]


class AsyncClient(AsyncConnection):
    """Talks to a geoswarm service. Lives in one event loop; close it, or use it in an ``async with`` statement.

    Parameters
    ----------
    base_url
        Address of the service; GEOSWARM_URL or http://127.0.0.1:8765 when not given.
    api_key
        GEOSWARM_API_KEY when not given.
    timeout
        Longest time for the answer to one request [s].
    patience
        How long the service may be unreachable while events are followed, for example in a restart [s].
    stream_timeout
        A connection with events is renewed after this time without data or heartbeats [s].
    transport
        Replaces the network, for tests.

    Raises
    ------
    GeoswarmError
        Every method: see :mod:`geoswarm.client.errors`.

    Examples
    --------
    >>> from geoswarm import AsyncClient
    >>> problem = {
    ...     "forward_model": {"kind": "formula", "series": {"y": {"expression": "a * x"}}},
    ...     "parameters": {"a": {"lower": 0, "upper": 10}},
    ...     "observations": [{"series": "y", "points": {"x": [1, 2], "y": [2, 4]}}],
    ...     "stopping": {"max_evaluations": 60},
    ...     "seed": 1,
    ... }
    >>> async with AsyncClient() as client:
    ...     job = await client.submit(problem)
    ...     job = await client.wait(job.id, timeout=60)
    >>> print(job.state, round(job.parameters["a"], 2))
    finished 2.0
    """

    submit = jobs.submit
    list = jobs.list_jobs
    iterate_jobs = jobs.iterate_jobs
    get = jobs.get
    problem = jobs.problem
    cancel = jobs.cancel
    pause = jobs.pause
    resume = jobs.resume
    change_stopping = jobs.change_stopping
    label = jobs.label
    retry_failed = jobs.retry_failed
    delete = jobs.delete

    attachments = attached.attachments
    attach = attached.attach
    download_attachment = attached.download_attachment
    delete_attachment = attached.delete_attachment

    events = following.events
    wait = following.wait

    best = results.best
    generations = results.generations
    evaluations = results.evaluations
    iterate_evaluations = results.iterate_evaluations
    download_evaluations = results.download_evaluations
    evaluation = results.evaluation
    attempts = results.attempts
    fit = results.fit
    points = results.points
    mesh = results.mesh
    mesh_fields = results.mesh_fields

    statistics = analysis.statistics
    reweight = analysis.reweight
    sensitivity = analysis.sensitivity
    profile = analysis.profile
    jackknife = analysis.jackknife
    explore = analysis.explore
    predict = analysis.predict
    design = analysis.design
    global_sensitivity = analysis.global_sensitivity
    uncertainty = analysis.uncertainty
    posterior = analysis.posterior
    surface = analysis.surface
    report = reports.report
    report_pdf = reports.report_pdf
    figures = reports.figures
    figure = reports.figure

    check = drafts.check
    warm_starts = drafts.warm_starts
    read_problem = drafts.read_problem
    read_measurements = drafts.read_measurements
    read_ags = drafts.read_ags
    import_ags = drafts.import_ags
    examples = drafts.examples
    example = drafts.example
    problem_schema = drafts.problem_schema

    forward_models = service.forward_models
    forward_model = service.forward_model
    workers = service.workers
    health = service.health
    session = service.session
    operations = service.operations
    keys = service.keys
    create_key = service.create_key
    revoke_key = service.revoke_key
    links = service.links
    create_link = service.create_link
    revoke_link = service.revoke_link
    hooks = service.hooks
    create_hook = service.create_hook
    test_hook = service.test_hook
    delete_hook = service.delete_hook

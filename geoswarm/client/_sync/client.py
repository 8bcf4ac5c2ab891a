# Generated from geoswarm/client/_async/client.py by scripts/generate_client.py; `make format` renews it.
"""What the service can be asked."""

from __future__ import annotations

from geoswarm.client._sync import analysis, drafts, following, jobs, results, service
from geoswarm.client._sync.connection import Connection

__all__ = ["Client"]


class Client(Connection):
    """Talks to a geoswarm service. Safe to use from several threads; close it, or use it in a ``with`` statement.

    Parameters
    ----------
    base_url
        Address of the service; GEOSWARM_URL or http://127.0.0.1:8765 when not given.
    api_key
        GEOSWARM_API_KEY when not given.
    timeout
        How long one request may take to answer [s].
    patience
        How long the service may be out of reach while events are followed, for example in a restart [s].
    stream_timeout
        A connection with events is renewed when nothing, not even a sign of life, came for so long [s].
    transport
        Replaces the network, for tests.

    Raises
    ------
    GeoswarmError
        Every method: see :mod:`geoswarm.client.errors`.
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
    retry_failed = jobs.retry_failed
    delete = jobs.delete

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
    global_sensitivity = analysis.global_sensitivity
    uncertainty = analysis.uncertainty
    posterior = analysis.posterior
    report = analysis.report
    report_pdf = analysis.report_pdf
    figures = analysis.figures
    figure = analysis.figure

    check = drafts.check
    warm_starts = drafts.warm_starts
    read_problem = drafts.read_problem
    read_measurements = drafts.read_measurements
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

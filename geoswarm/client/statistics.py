"""The part of both clients about statistics, uncertainty and reports."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeVar

from geoswarm.client import statistics_calls as calls
from geoswarm.client.calls import Call
from geoswarm.client.models import Figure, Job, Report
from geoswarm.client.statistics_calls import Noise

__all__ = ["AsyncStatistics", "Statistics"]

T = TypeVar("T")


class Statistics(ABC):
    """Statistics, uncertainty and reports of jobs; part of :class:`geoswarm.client.Client`."""

    @abstractmethod
    def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    def statistics(self, job_id: str, *, threshold: float | None = None, noise: Noise = None) -> dict[str, Any]:
        """Judge the parameters of a job from its stored evaluations: verdicts, correlations, projections, proposals.

        Parameters
        ----------
        threshold
            Objective up to which a fit is good; proposed by the service when None.
        noise
            Known standard deviation of a reading, base units, one for all series or one each.
        """
        return self._send(calls.statistics(job_id, threshold, noise))

    def reweight(
        self,
        job_id: str,
        *,
        weights: Mapping[str, float] | None = None,
        point_weights: Mapping[str, Sequence[float]] | None = None,
        weighting: str | None = None,
        noise: Noise = None,
    ) -> dict[str, Any]:
        """Calculate the objectives that the stored responses have under other weights; no forward run.

        Parameters
        ----------
        weights, point_weights
            w_g by series and w_h of every point by series.
        weighting
            ``by_error``, ``by_count`` or ``by_range`` in place of ``weights``, or ``by_spread`` for those of points.
        noise
            Standard deviation of a reading, base units, for ``by_error``.
        """
        call = calls.reweight(job_id, weights=weights, point_weights=point_weights, weighting=weighting, noise=noise)
        return self._send(call)

    def sensitivity(
        self,
        job_id: str,
        *,
        polish: bool = True,
        step: float | None = None,
        at: Mapping[str, float] | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates the sensitivities at the optimum of a job: standard errors, intervals.

        Parameters
        ----------
        polish
            Go to the minimum first; without, one generation at the best evaluation.
        step
            Largest difference in parts of the searched range; 0.005 when None.
        at
            Another optimum: values of the free parameters.
        """
        request = {"polish": polish, "step": step, "at": at}
        return self._send(calls.follow_up(job_id, "sensitivity", idempotency_key, **request))

    def profile(
        self,
        job_id: str,
        *,
        parameters: Sequence[str] | None = None,
        noise: Noise = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates profile objectives; the job must have its sensitivities already.

        Parameters
        ----------
        parameters
            Those to profile; all free ones when None.
        noise
            Known standard deviation of a reading, base units.
        """
        request = {"parameters": parameters, "noise": noise}
        return self._send(calls.follow_up(job_id, "profile", idempotency_key, **request))

    def global_sensitivity(
        self,
        job_id: str,
        *,
        kind: Literal["sobol", "morris"] = "sobol",
        samples: int | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates the design of Sobol or Morris over the whole search range.

        Parameters
        ----------
        samples
            Base points, a power of two (256 when None), or trajectories (20).
        """
        request = {"kind": kind, "samples": samples}
        return self._send(calls.follow_up(job_id, "global-sensitivity", idempotency_key, **request))

    def uncertainty(self, job_id: str, *, noise: Noise = None) -> dict[str, Any]:
        """Show what the follow-ups of a job have found: intervals, profiles, global sensitivities."""
        return self._send(calls.uncertainty(job_id, noise))

    def posterior(self, job_id: str, *, noise: Noise = None) -> dict[str, Any]:
        """Sample the posterior through a checked response surface of the stored evaluations; no forward run."""
        return self._send(calls.posterior(job_id, noise))

    def report(
        self, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
    ) -> Report:
        """Show the report of a job, on request with a posterior sample; a notebook displays it."""
        return self._send(calls.report(job_id, threshold, noise, posterior))

    def report_pdf(
        self, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
    ) -> bytes:
        """Show the report of a job as PDF."""
        return self._send(calls.report_pdf(job_id, threshold, noise, posterior))

    def figures(self, job_id: str, *, noise: Noise = None, posterior: bool = False) -> tuple[str, ...]:
        """List the figures that can be drawn of a job."""
        return self._send(calls.figures(job_id, noise, posterior))

    def figure(
        self,
        job_id: str,
        name: str,
        *,
        form: Literal["svg", "png", "csv"] = "svg",
        threshold: float | None = None,
        noise: Noise = None,
        posterior: bool = False,
    ) -> Figure:
        """Show a figure of a job, or (csv) the numbers behind it; a notebook displays it."""
        return self._send(calls.figure(job_id, name, form, threshold, noise, posterior))


class AsyncStatistics(ABC):
    """Statistics, uncertainty and reports of jobs; part of :class:`geoswarm.client.AsyncClient`."""

    @abstractmethod
    async def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    async def statistics(self, job_id: str, *, threshold: float | None = None, noise: Noise = None) -> dict[str, Any]:
        """Judge the parameters of a job from its stored evaluations: verdicts, correlations, projections, proposals.

        Parameters
        ----------
        threshold
            Objective up to which a fit is good; proposed by the service when None.
        noise
            Known standard deviation of a reading, base units, one for all series or one each.
        """
        return await self._send(calls.statistics(job_id, threshold, noise))

    async def reweight(
        self,
        job_id: str,
        *,
        weights: Mapping[str, float] | None = None,
        point_weights: Mapping[str, Sequence[float]] | None = None,
        weighting: str | None = None,
        noise: Noise = None,
    ) -> dict[str, Any]:
        """Calculate the objectives that the stored responses have under other weights; no forward run.

        Parameters
        ----------
        weights, point_weights
            w_g by series and w_h of every point by series.
        weighting
            ``by_error``, ``by_count`` or ``by_range`` in place of ``weights``, or ``by_spread`` for those of points.
        noise
            Standard deviation of a reading, base units, for ``by_error``.
        """
        call = calls.reweight(job_id, weights=weights, point_weights=point_weights, weighting=weighting, noise=noise)
        return await self._send(call)

    async def sensitivity(
        self,
        job_id: str,
        *,
        polish: bool = True,
        step: float | None = None,
        at: Mapping[str, float] | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates the sensitivities at the optimum of a job: standard errors, intervals.

        Parameters
        ----------
        polish
            Go to the minimum first; without, one generation at the best evaluation.
        step
            Largest difference in parts of the searched range; 0.005 when None.
        at
            Another optimum: values of the free parameters.
        """
        request = {"polish": polish, "step": step, "at": at}
        return await self._send(calls.follow_up(job_id, "sensitivity", idempotency_key, **request))

    async def profile(
        self,
        job_id: str,
        *,
        parameters: Sequence[str] | None = None,
        noise: Noise = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates profile objectives; the job must have its sensitivities already.

        Parameters
        ----------
        parameters
            Those to profile; all free ones when None.
        noise
            Known standard deviation of a reading, base units.
        """
        request = {"parameters": parameters, "noise": noise}
        return await self._send(calls.follow_up(job_id, "profile", idempotency_key, **request))

    async def global_sensitivity(
        self,
        job_id: str,
        *,
        kind: Literal["sobol", "morris"] = "sobol",
        samples: int | None = None,
        idempotency_key: str | None = None,
    ) -> Job:
        """Submit a follow-up that evaluates the design of Sobol or Morris over the whole search range.

        Parameters
        ----------
        samples
            Base points, a power of two (256 when None), or trajectories (20).
        """
        request = {"kind": kind, "samples": samples}
        return await self._send(calls.follow_up(job_id, "global-sensitivity", idempotency_key, **request))

    async def uncertainty(self, job_id: str, *, noise: Noise = None) -> dict[str, Any]:
        """Show what the follow-ups of a job have found: intervals, profiles, global sensitivities."""
        return await self._send(calls.uncertainty(job_id, noise))

    async def posterior(self, job_id: str, *, noise: Noise = None) -> dict[str, Any]:
        """Sample the posterior through a checked response surface of the stored evaluations; no forward run."""
        return await self._send(calls.posterior(job_id, noise))

    async def report(
        self, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
    ) -> Report:
        """Show the report of a job, on request with a posterior sample; a notebook displays it."""
        return await self._send(calls.report(job_id, threshold, noise, posterior))

    async def report_pdf(
        self, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
    ) -> bytes:
        """Show the report of a job as PDF."""
        return await self._send(calls.report_pdf(job_id, threshold, noise, posterior))

    async def figures(self, job_id: str, *, noise: Noise = None, posterior: bool = False) -> tuple[str, ...]:
        """List the figures that can be drawn of a job."""
        return await self._send(calls.figures(job_id, noise, posterior))

    async def figure(
        self,
        job_id: str,
        name: str,
        *,
        form: Literal["svg", "png", "csv"] = "svg",
        threshold: float | None = None,
        noise: Noise = None,
        posterior: bool = False,
    ) -> Figure:
        """Show a figure of a job, or (csv) the numbers behind it; a notebook displays it."""
        return await self._send(calls.figure(job_id, name, form, threshold, noise, posterior))

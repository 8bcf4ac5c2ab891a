"""What was found beyond the stored evaluations of a run: by follow-ups, and by a posterior sample."""

from __future__ import annotations

from dataclasses import dataclass

from geoswarm.solver.identifiability.stored.findings import NO_FINDINGS, Findings
from geoswarm.solver.identifiability.stored.posterior import Posterior
from geoswarm.solver.words import number, per_cent

__all__ = ["NOTHING_FURTHER", "Uncertainty"]


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """Findings of follow-ups and a posterior sample, where somebody asked for them."""

    findings: Findings = NO_FINDINGS
    posterior: Posterior | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """What to be careful about, in sentences."""
        found = [*self.findings.notes, *(() if self.posterior is None else self.posterior.warnings)]
        found += [
            f"the profile of {profile.parameter} found a lower objective than the optimum: the search had not found "
            "the best fit"
            for profile in self.findings.profiles
            if profile.better is not None
        ]
        return tuple(f"{note[:1].upper()}{note[1:]}{'' if note.endswith('.') else '.'}" for note in found)

    def summary(self, evaluations: int) -> str:
        """Say in a sentence what a follow-up without verdicts has."""
        findings = self.findings
        if findings.profiles:
            closed = [profile.parameter for profile in findings.profiles if profile.interval is not None]
            return (
                f"Profile objectives of {', '.join(profile.parameter for profile in findings.profiles)}; closed "
                f"intervals: {', '.join(closed) or 'none'}."
            )
        if findings.jackknife is not None:
            without = findings.jackknife
            pulls = [f"{name} by {test}" for name in without.names if (test := without.pulling(name)) is not None]
            return f"Fitted without each of {len(without.tests)} tests. Pulled most: {', '.join(pulls)}."
        if findings.global_sensitivities:
            first = findings.global_sensitivities[0]
            order = sorted(first.indices, key=lambda index: -index.main)
            return f"Influence on the objective, the largest first: {', '.join(i.parameter for i in order)}."
        if findings.predictions:
            prediction = findings.predictions[0]
            ends = [
                f"{one.series} {number(float(one.median[-1]))} ({number(float(one.lower[-1]))} … "
                f"{number(float(one.upper[-1]))}) {one.y_unit}".rstrip()
                + f" at {one.x_quantity} {number(float(one.x[-1]))} {one.x_unit}".rstrip()
                for one in prediction.series
            ]
            return f"Median and {per_cent(prediction.level)} band: {'; '.join(ends)}."
        if findings.designs:
            first_two = " then ".join(candidate.name for candidate in findings.designs[0].candidates[:2])
            return f"The most informative test: {first_two}."
        return f"No result yet after {evaluations} evaluations of this follow-up."


NOTHING_FURTHER = Uncertainty()

"""Headings and captions of the figures of a report."""

from __future__ import annotations

__all__ = ["CAPTIONS"]

CAPTIONS: dict[str, tuple[str, str, bool]] = {
    "matrix": (
        "What the data can tell",
        "Diagonal: objective over one parameter with its lower envelope; a firm single minimum means that the data "
        "determine the parameter. Below: good fits by their objective, other evaluations grey. Above: Pearson's r of "
        "the good fits with its 95 % interval, Spearman's ρ and the number of good fits.",
        True,
    ),
    "intervals": (
        "Parameters between their bounds",
        "Search range, the middle 90 % of the good fits, and, where the parameter is identifiable at the optimum, its "
        "confidence interval.",
        False,
    ),
    "profiles": (
        "Profile objectives",
        "The lowest objective for every value of one parameter, the others refitted. The interval ends where the "
        "profile crosses the dashed line; where it stays below up to the bound, the data do not limit the parameter.",
        True,
    ),
    "posterior": (
        "Posterior sample",
        "Distribution of each parameter by a Markov chain through the response surface of the stored evaluations; "
        "shaded: the credible interval.",
        True,
    ),
    "global_sensitivity": (
        "Influence over the whole search range",
        "Sobol: share of the variation that a parameter explains alone, and with all its interactions. Morris: mean "
        "absolute elementary effect, and its spread. Whiskers: 95 % intervals.",
        True,
    ),
    "prediction": (
        "Prediction",
        "Effect of the uncertainty of the identified parameters on another forward model: median, and the band that "
        "holds the stated share at each x. Dotted: the same for future readings, which have an error of their own. "
        "Dashed: the curve at the optimum, of several basins at each with its share.",
        True,
    ),
    "design": (
        "Which test next",
        "Candidate tests or measuring points by how much they would narrow the intervals: the bar by the "
        "criterion of the order, a mark for each parameter. Expected from the sensitivities at the optimum, of all "
        "basins and of draws around them.",
        True,
    ),
    "sketch": ("The test", "The specimen or the ground, and the loading programme.", True),
    "fit": (
        "Fit",
        "Measured and calculated series; residual = calculated − measured; distance: that of a reading from the "
        "calculated curve, x and y in parts of their ranges.",
        False,
    ),
    "stages": ("Fit by stage", "Each load over the logarithm of the time since its application.", True),
    "tests": (
        "All tests",
        "Marks: readings, at most 30 of a test; lines: the best evaluation; dashed: the set of parameters that is "
        "compared with, if there is one.",
        True,
    ),
    "compression": (
        "Compression curve",
        "State at the end of each stage over the logarithm of stress: the last reading of the stage and the best "
        "evaluation. Dashed: preconsolidation stress that follows from OCR or POP; shaded: its 95 % interval, where "
        "it holds.",
        False,
    ),
    "classical": (
        "Classical evaluation",
        "Classical evaluation of the readings, without the model: lines and points. Root and logarithm of time "
        "belong to the largest load that allows them; strains are those of the initial height.",
        True,
    ),
    "convergence": ("Convergence", "Lowest objective found over the number of evaluations.", False),
    "traces": (
        "Parameters during the search",
        "Dots: all evaluations; line: best so far; dotted: the bounds.",
        False,
    ),
}
"""Heading, caption and whether it needs the whole width, by the name of a figure up to its first dot."""

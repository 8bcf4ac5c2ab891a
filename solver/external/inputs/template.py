"""Our own templates: input files of a program with placeholders for numbers.

::

    *ELASTIC
    {{E}}, {{nu:%.6e}}
    {{2 * G * (1 + nu)}} {{expr:%10.3f}}
    port {{4000 + slot}}

A placeholder is an expression (:mod:`geoswarm.solver.expressions`) of parameters and of ``slot``, the number of the
place where the run happens, from 0. It is on one line. After a colon follows a format (``%e %f %g %d %s`` with
width and digits). Without one a number is written with as many digits as bring back the same bits, 17 at most, and
always with a decimal point: ``20.0``, ``1.0e-05``; what is made of ``slot`` and numbers alone, and is whole, is written
without one.

Braces: a single ``{``, and any ``}}`` outside a placeholder, stand for themselves; ``{{{{`` stands for ``{{``. Of a
longer row of opening braces each four stand for two; of three that remain the first stands for itself: ``{{{E}}}`` is
``{20.0}``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import MAX_LENGTH, Expression, parse_expression
from geoswarm.solver.external.errors import InputError, TemplateError, place
from geoswarm.solver.external.inputs.formats import NumberFormat, parse_format
from geoswarm.solver.external.inputs.texts import checked, number_text
from geoswarm.solver.words import did_you_mean

__all__ = ["SLOT", "Placeholder", "Template", "parse_template"]

SLOT = "slot"
"""Name of the number of the place where a run happens."""

_OPENING = re.compile(r"\{{2,}")
_CLOSING = re.compile(r"\}\}|\{\{|[\r\n]")
_LONGEST = MAX_LENGTH + 50


@dataclass(frozen=True, slots=True)
class Placeholder:
    """One placeholder and its place; line and column count from 1."""

    expression: Expression
    format: NumberFormat | None
    line: int
    column: int

    def write(self, values: Mapping[str, float], file: str) -> str:
        """Write the value.

        Raises
        ------
        InputError
            It is not finite, or does not fit the format; the message names file, line and column.
        """
        where = place(file, self.line, self.column)
        value = checked(float(self.expression.value(values)), f"{where}: {self.expression.text}")
        try:
            if self.format is not None:
                return self.format.write(value)
        except InputError as error:
            raise InputError(f"{where}: {self.expression.text}: {error}") from None
        if self.expression.names == {SLOT} and value.is_integer():
            return str(int(value))
        return number_text(value)


@dataclass(frozen=True, slots=True)
class Template:
    """A template that was read, ready to be filled many times. ``file`` is its name in messages.

    Examples
    --------
    >>> parse_template("E={{E}} nu={{nu:%.2f}}", "deck.in").fill({"E": 2e4, "nu": 0.3})
    'E=20000.0 nu=0.30'
    """

    file: str
    pieces: tuple[str | Placeholder, ...]

    @property
    def placeholders(self) -> tuple[Placeholder, ...]:
        """The placeholders in the order of the file."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Placeholder))

    @property
    def names(self) -> frozenset[str]:
        """The parameters that the template uses."""
        return frozenset(name for one in self.placeholders for name in one.expression.names) - {SLOT}

    def used(self, known: Collection[str]) -> frozenset[str]:
        """Which of the known parameters the template uses."""
        return self.names & frozenset(known)

    def check(self, known: Collection[str]) -> None:
        """Compare the names with the known parameters.

        Raises
        ------
        TemplateError
            A name is not a parameter; the message names its place, and a parameter that may be meant.
        """
        for one in self.placeholders:
            for name in sorted(one.expression.names - {SLOT}):
                if name not in known:
                    listed = ", ".join(sorted(known)[:20]) or "none"
                    message = f"{name} is not a parameter{did_you_mean(name, known)}; parameters: {listed}"
                    raise TemplateError(message, self.file, one.line, one.column)

    def fill(self, values: Mapping[str, float]) -> str:
        """Return the file with values instead of placeholders.

        Parameters
        ----------
        values
            By parameter, and ``slot`` where the template uses it; further ones are ignored.

        Raises
        ------
        TemplateError
            A name has no value.
        InputError
            A value is not finite or does not fit its format.
        """
        names = self.names | ({SLOT} & {name for one in self.placeholders for name in one.expression.names})
        if not names <= values.keys():
            self.check([name for name in values if name != SLOT])
            raise TemplateError(f"{SLOT} has no value here", self.file)
        return "".join(piece if isinstance(piece, str) else piece.write(values, self.file) for piece in self.pieces)


def parse_template(text: str, file: str) -> Template:
    """Read a template; takes time in proportion to its length.

    Raises
    ------
    TemplateError
        A placeholder is not closed, or its expression or format is not understood.
    """
    pieces: list[str | Placeholder] = []
    position, line, line_start = 0, 1, 0
    while (found := _OPENING.search(text, position)) is not None:
        line += text.count("\n", position, found.start())
        line_start = max(line_start, text.rfind("\n", position, found.start()) + 1)
        braces = len(found[0])
        pieces.append(text[position : found.start()] + "{" * (2 * (braces // 4) + braces % 2))
        position = found.end()
        if braces % 4 >= 2:
            start = found.end()
            where = (file, line, start - 1 - line_start)
            inside = _inside(text, start, where)
            pieces.append(_placeholder(inside, where))
            position = start + len(inside) + 2
    pieces.append(text[position:])
    return Template(file, tuple(piece for piece in pieces if piece))


def _inside(text: str, start: int, where: tuple[str, int, int]) -> str:
    closing = _CLOSING.search(text, start, start + _LONGEST)
    if closing is not None and closing[0] == "}}":
        return text[start : closing.start()]
    beginning = text[start : start + 20].partition("\n")[0].rstrip()
    what = f"'{{{{{beginning}'"
    rule = "close it with }} in the same line, or write {{{{ for two braces that stand for themselves"
    if closing is None and len(text) > start + _LONGEST:
        raise TemplateError(f"placeholder {what} is longer than {_LONGEST} characters; {rule}", *where)
    raise TemplateError(f"placeholder {what} is not closed; {rule}", *where)


def _placeholder(inside: str, where: tuple[str, int, int]) -> Placeholder:
    formula, colon, form = inside.partition(":")
    if not formula.strip():
        raise TemplateError("placeholder is empty; write a parameter or an expression, such as {{E}}", *where)
    try:
        expression = parse_expression(formula)
        if expression.is_comparison:
            raise TemplateError(f"'{expression.text}' is a comparison; a number is wanted", *where)
        return Placeholder(expression, parse_format(form.strip()) if colon else None, where[1], where[2])
    except (ExpressionError, ValueError) as error:
        raise TemplateError(f"placeholder {{{{{inside}}}}}: {error}", *where) from None

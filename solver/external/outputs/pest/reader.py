"""Series from files that an instruction file of PEST reads.

::

    head: {file: out.dat, instructions: out.ins, observations: {h1: 10, h2: 20}}
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from geoswarm.solver.external.errors import OutputError, TemplateError
from geoswarm.solver.external.inputs.texts import read_template_file
from geoswarm.solver.external.outputs.base import Point, ScaledReader
from geoswarm.solver.external.outputs.fields import below, relative_path
from geoswarm.solver.external.outputs.lines import Encoding, lines_of
from geoswarm.solver.external.outputs.pest.follow import follow
from geoswarm.solver.external.outputs.pest.instructions import Instructions, parse_instructions
from geoswarm.solver.words import did_you_mean

__all__ = ["PestReader"]


class PestReader(ScaledReader):
    """Named values that an instruction file reads, each at its x.

    ``instructions`` is the name of the instruction file, or its text: whatever begins with ``pif`` and has several
    lines.
    """

    told_by: ClassVar[str] = "PEST instructions (file, instructions and observations)"

    format: Literal["pest"] = Field("pest", description="May be left out.")
    instructions: str = Field(max_length=10_000_000, description="Instruction file next to the problem, or its text.")
    observations: dict[str, float] = Field(
        min_length=1, max_length=1_000_000, description="x of each observation that the instructions read."
    )
    encoding: Encoding = Field("utf-8", description="How characters are written.")

    @field_validator("instructions")
    @classmethod
    def _file_or_text(cls, text: str) -> str:
        return text if "\n" in text else relative_path(text)

    @model_validator(mode="after")
    def _text_is_sound(self) -> PestReader:
        if self._is_text:
            try:
                self._parsed(self.instructions, "instructions")
            except TemplateError as error:
                raise ValueError(str(error)) from error
        return self

    @property
    def _is_text(self) -> bool:
        return "\n" in self.instructions

    @property
    def sources(self) -> tuple[str, ...]:
        """The instruction file, unless its text is given."""
        return () if self._is_text else (self.instructions,)

    def with_sources(self, folder: Path) -> PestReader:
        """Return the same reader with the text of the instruction file; raises TemplateError."""
        if self._is_text:
            return self
        text = read_template_file(below(folder, self.instructions)).replace("\r\n", "\n")
        self._parsed(text, self.instructions)
        return self.model_copy(update={"instructions": text if "\n" in text else text + "\n"})

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points in the order of ``observations``; the file is read line by line."""
        name = "instructions" if self._is_text else self.instructions
        try:
            instructions = self._parsed(self.with_sources(folder).instructions, name)
        except TemplateError as error:
            raise OutputError("bad_output", f"{self.file}: {error}") from None
        values = follow(instructions, lines_of(folder, self.file, self.encoding), self.file)
        for observation, x in self.observations.items():
            value = values.get(observation.lower())
            if value is None:
                raise OutputError("bad_output", f"{self.file}: {observation} was not read")
            yield Point(x, self.y_factor * value.number, value.line, value.text)

    def _parsed(self, text: str, name: str) -> Instructions:
        instructions = parse_instructions(text, name)
        known = set(instructions.names)
        for observation in self.observations:
            if observation.lower() not in known:
                listed = ", ".join(instructions.names[:20]) or "nothing"
                hint = did_you_mean(observation.lower(), instructions.names)
                raise TemplateError(f"observation {observation} is not read{hint}; read are {listed}", name)
        return instructions

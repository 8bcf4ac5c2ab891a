"""Settings of a registered model: what its users may choose beside parameters. Data of a few types, never text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictFloat, StrictInt, StrictStr, model_validator

from geoswarm.solver.errors import Issue
from geoswarm.solver.words import did_you_mean

__all__ = ["Given", "Setting", "SettingName", "chosen", "numbers_of", "setting_issues", "texts_of"]

SettingName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=50)]
Given: TypeAlias = StrictBool | StrictInt | StrictFloat | StrictStr
"""A value that a user gives; text only as the name of a choice."""


class _Setting(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    description: str = Field("", max_length=300, description="What it is.")


class NumberSetting(_Setting):
    """A number within limits."""

    type: Literal["number", "integer"]
    default: float
    lower: float | None = None
    upper: float | None = None
    unit: str = Field("", max_length=50)

    @model_validator(mode="after")
    def _sound(self) -> NumberSetting:
        fault = self.fault(int(self.default) if self.type == "integer" and self.default.is_integer() else self.default)
        if fault:
            raise ValueError(f"default {fault}")
        return self

    def fault(self, value: Given) -> str | None:
        """What is wrong with a value, in words."""
        if isinstance(value, bool | str):
            return f"must be a number, got {value!r}"
        if self.type == "integer" and not float(value).is_integer():
            return f"must be a whole number, got {value:g}"
        low, high = self.lower, self.upper
        if (low is not None and value < low) or (high is not None and value > high):
            ends = (
                f"at least {low:g}" if high is None else f"at most {high:g}" if low is None else f"{low:g} to {high:g}"
            )
            return f"must be {ends}{f' {self.unit}' if self.unit else ''}, got {value:g}"
        return None

    def number(self, value: Given) -> float:
        """The value for templates."""
        return float(value)

    def text(self, value: Given) -> str:
        """The value for arguments and environment."""
        return str(int(value)) if self.type == "integer" else repr(float(value))


class SwitchSetting(_Setting):
    """On or off."""

    type: Literal["switch"]
    default: StrictBool = False

    def fault(self, value: Given) -> str | None:
        """What is wrong with a value, in words."""
        return None if isinstance(value, bool) else f"must be true or false, got {value!r}"

    def number(self, value: Given) -> float:
        """1 or 0."""
        return float(value)

    def text(self, value: Given) -> str:
        """1 or 0."""
        return str(int(bool(value)))


class ChoiceSetting(_Setting):
    """One of some names; templates get its number, arguments and environment its text."""

    type: Literal["choice"]
    choices: dict[SettingName, StrictFloat | StrictInt | StrictStr] = Field(
        min_length=1, max_length=100, description="What each name stands for: a number or a text."
    )
    default: str

    @model_validator(mode="after")
    def _sound(self) -> ChoiceSetting:
        fault = self.fault(self.default)
        if fault:
            raise ValueError(f"default {fault}")
        return self

    def fault(self, value: Given) -> str | None:
        """What is wrong with a value, in words."""
        if isinstance(value, str) and value in self.choices:
            return None
        return f"must be one of {', '.join(self.choices)}, got {str(value)[:60]!r}"

    def number(self, value: Given) -> float | None:
        """The number that it stands for; None: it is a text."""
        meaning = self.choices[str(value)]
        return None if isinstance(meaning, str) else float(meaning)

    def text(self, value: Given) -> str:
        """What it stands for."""
        meaning = self.choices[str(value)]
        return meaning if isinstance(meaning, str) else f"{meaning:.17g}"


Setting: TypeAlias = Annotated[NumberSetting | SwitchSetting | ChoiceSetting, Field(discriminator="type")]


def setting_issues(declared: Mapping[str, Setting], given: Mapping[str, Given], path: str) -> list[Issue]:
    """What is wrong with the settings of a problem."""
    issues = []
    for name, value in given.items():
        setting = declared.get(name)
        if setting is None:
            known = ", ".join(declared) or "none"
            issues.append(Issue(f"{path}.{name}", f"unknown setting{did_you_mean(name, declared)}; known: {known}"))
        elif fault := setting.fault(value):
            issues.append(Issue(f"{path}.{name}", fault))
    return issues


def chosen(declared: Mapping[str, Setting], given: Mapping[str, Given]) -> dict[str, Given]:
    """Value of every setting, the default where none is given."""
    return {name: given.get(name, setting.default) for name, setting in declared.items()}


def numbers_of(declared: Mapping[str, Setting], values: Mapping[str, Given]) -> dict[str, float]:
    """The settings that are numbers, for templates and files of parameters."""
    found = {name: setting.number(values[name]) for name, setting in declared.items()}
    return {name: number for name, number in found.items() if number is not None}


def texts_of(declared: Mapping[str, Setting], values: Mapping[str, Given]) -> dict[str, str]:
    """All settings as text, for arguments and environment."""
    return {name: setting.text(values[name]) for name, setting in declared.items()}

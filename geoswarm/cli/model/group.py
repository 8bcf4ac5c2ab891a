"""``geoswarm model``: programs of your own as forward models."""

from __future__ import annotations

import click

from geoswarm.cli.model.build_umat import build_umat_command
from geoswarm.cli.model.new import new_command
from geoswarm.cli.model.trial import try_command

__all__ = ["model_command"]


@click.group("model")
def model_command() -> None:
    """Use your own program as a forward model, and test it."""


model_command.add_command(new_command)
model_command.add_command(try_command)
model_command.add_command(build_umat_command)

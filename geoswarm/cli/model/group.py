"""``geoswarm model``: programs of your own as forward models, and libraries of Abaqus user routines."""

from __future__ import annotations

from pathlib import Path

import click

from geoswarm.cli.model.new import new_command
from geoswarm.cli.model.trial import try_command
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

__all__ = ["build_umat_command", "model_command"]


@click.command("build-umat")
@click.argument(
    "sources", nargs=-1, required=True, type=click.Path(dir_okay=False, path_type=Path), metavar="SOURCE..."
)
@click.option(
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Library to write; lib<first source>.so next to the first source if not given.",
)
@click.option("--function", default="umat_", show_default=True, help="Symbol of the routine.")
@click.option("--compiler", default="gfortran", show_default=True, help="gfortran, by name or path.")
@click.option("--flag", "flags", multiple=True, metavar="FLAG", help="Further flag of the compiler; may be repeated.")
def build_umat_command(
    sources: tuple[Path, ...], output: Path | None, function: str, compiler: str, flags: tuple[str, ...]
) -> None:
    """Compile the Fortran sources of an Abaqus user routine (UMAT) to a library.

    ABA_PARAM.INC and the utilities that routines call (SINV, SPRINC, SPRIND, ROTSIG, XIT, STDB_ABQERR) are supplied;
    XIT and STOP end a run, not the process. An existing library is replaced.

        geoswarm model build-umat sand.f --output libsand.so

        geoswarm model build-umat sand.f --flag=-fcheck=bounds --flag=-g
    """
    from geoswarm.solver.user_laws.build import BuildError, build_umat

    library = sources[0].with_name(f"lib{sources[0].stem}.so") if output is None else output
    try:
        built = build_umat(sources, library, function=function, compiler=compiler, flags=flags)
    except BuildError as error:
        raise BadInputError(str(error)) from None
    if built.printed:
        note(built.printed)
    note(f"Written: {library}")
    note(f"In a problem next to it: material: {{law: umat, library: {library.name}, parameters: ..., props: [...]}}")


@click.group("model")
def model_command() -> None:
    """Use your own program as a forward model, and test it."""


model_command.add_command(new_command)
model_command.add_command(try_command)
model_command.add_command(build_umat_command)

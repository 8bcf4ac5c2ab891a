"""How every figure looks, and how it becomes a file: one palette, one set of sizes, one lock.

Colours are those of Okabe and Ito, and a part of viridis for values: told apart with every common colour vision, and
visible on white as on black. Ink, muted ink, grid, paper and what sketches are filled with have colours of their own
that :func:`inline_svg` replaces by those of the page.
"""

from __future__ import annotations

import io
import re
import textwrap
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.system.extras import has
from geoswarm.solver.words import power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

__all__ = [
    "BLUE",
    "GREEN",
    "GRID",
    "INK",
    "MARL",
    "MUTED",
    "ORANGE",
    "PAPER",
    "SKY",
    "SOIL",
    "STEEL",
    "STONE",
    "colour_map",
    "drawing",
    "figures_available",
    "finish",
    "head",
    "inline_svg",
    "plain_ticks",
    "plot_gross_errors",
    "plot_measured",
    "point_settlement_down",
    "png_of",
    "save_figure",
    "shortened",
    "svg_of",
    "tick_text",
    "with_unit",
]

INK, MUTED, GRID = "#1b1f24", "#6a7178", "#d5d9dd"
PAPER, SOIL, STEEL, STONE, MARL = "#fefefe", "#ead9bd", "#c3c8cd", "#e4e2dc", "#cdd8b6"
BLUE, SKY, ORANGE, GREEN = "#0072B2", "#56B4E9", "#D55E00", "#009E73"

_SETTINGS: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "figure.titlesize": 10.5,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.facecolor": "none",
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "axes.unicode_minus": True,
    "svg.hashsalt": "geoswarm",
    "svg.fonttype": "none",
    "mathtext.default": "regular",
}

_ROLES = (
    (INK, "currentColor"),
    (MUTED, "var(--muted)"),
    (GRID, "var(--grid)"),
    (PAPER, "var(--paper)"),
    (SOIL, "var(--soil)"),
    (MARL, "var(--marl)"),
    (STEEL, "var(--steel)"),
    (STONE, "var(--stone)"),
)

_LOCK = threading.RLock()  # matplotlib's settings and font caches belong to the process, not to a thread
_RENDERED: WeakKeyDictionary[Figure, dict[str, bytes]] = WeakKeyDictionary()  # by form


def figures_available() -> bool:
    """Return whether matplotlib (the ``plots`` extra) is installed."""
    return has("matplotlib")


@contextmanager
def drawing() -> Iterator[None]:
    """Draw or render in the body with the settings of the house, one thread at a time."""
    import matplotlib as mpl

    with _LOCK, mpl.rc_context(_SETTINGS):
        yield


def colour_map() -> Colormap:
    """Return the part of viridis that is visible on white and on black; dark is a low value."""
    import matplotlib as mpl
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("viridis_part", mpl.colormaps["viridis"]([0.14, 0.3, 0.5, 0.7, 0.86]))


def with_unit(quantity: str, unit: str) -> str:
    """Return an axis label; a pure number has the unit ``-``."""
    return f"{quantity} [{unit if unit not in ('', '1', 'dimensionless') else '-'}]"


def head(figure: Figure, title: str) -> None:
    """Give a figure its title, on several lines where it is longer than the figure is wide."""
    figure.suptitle(textwrap.fill(title, _title_length(figure)), weight="bold")


def shortened(figure: Figure, title: str) -> str:
    """A title cut to one line of a figure."""
    length = _title_length(figure)
    return title if len(title) <= length else title[: length - 1].rstrip() + "…"


def _title_length(figure: Figure) -> int:
    return int(10.0 * figure.get_size_inches()[0])  # letters of this size in an inch


def plot_measured(axes: Axes, x: FloatArray, y: FloatArray) -> None:
    """Draw measured points, shape (m,) each, as open circles over everything else."""
    axes.plot(
        x,
        y,
        linestyle="none",
        marker="o",
        markersize=3.4,
        markerfacecolor="none",
        markeredgecolor=INK,
        markeredgewidth=0.7,
        label="measured",
        zorder=4,
    )


def plot_gross_errors(axes: Axes, x: FloatArray, y: FloatArray) -> None:
    """Draw readings that are left out, shape (q,) each, as crosses."""
    if x.size:
        axes.plot(x, y, linestyle="none", marker="x", markersize=5, color=ORANGE, label="gross error", zorder=4)


def finish(axes: Axes, *, legend: bool = True) -> None:
    """Give axes a faint grid and a legend that stays readable over points; no lines where nothing is measured."""
    axes.grid(visible=True, color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if legend:
        axes.legend(facecolor=PAPER, framealpha=0.85, edgecolor="none")


def point_settlement_down(axes: Axes, series: str, quantity: str) -> None:
    """Let the y axis of a settlement point downwards, as it is drawn in soil mechanics."""
    if quantity == "settlement" or series.endswith("settlement"):
        axes.invert_yaxis()


def plain_ticks(axes: Axes, which: str, *, log: bool, most: int = 4, inset: bool = False, whole: bool = False) -> None:
    """Give the ``x`` or ``y`` axis few ticks that do not collide, numbers without mathematical markup.

    Parameters
    ----------
    log
        Whether the axis is logarithmic.
    most
        Number of labelled ticks, about.
    inset
        Whether the outermost labels must stay within the axis, because another one follows.
    whole
        Whether only whole numbers make sense.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    if log:
        (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    low, high = sorted(axes.get_xlim() if which == "x" else axes.get_ylim())
    if not log:
        axis.set_major_locator(MaxNLocator(most, min_n_ticks=1 if whole else 2, integer=whole))
    elif high / 20.0 < low:  # little more than a decade: numbers in between say more than powers
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=most + 4))
    else:
        axis.set_major_locator(LogLocator(numticks=most))
    margin = 0.07 if inset else -1.0

    def written(value: float, _position: object) -> str:
        if log and value <= 0.0:  # a power of ten below the smallest number
            return ""
        first, at, last = np.log([low, value, high]) if log else (low, value, high)
        return tick_text(value) if margin <= (at - first) / (last - first) <= 1.0 - margin else ""

    axis.set_major_formatter(FuncFormatter(written))
    if log:
        axis.set_minor_formatter(NullFormatter())


def tick_text(value: float) -> str:
    """Return a number for a tick: ``0.05``, ``20000``, ``10⁻⁶``, ``5·10⁻⁷``."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")
    mantissa, _, power = f"{value:.3g}".partition("e") if "e" in f"{value:.3g}" else f"{value:.2e}".partition("e")
    mantissa = f"{float(mantissa):g}".replace("-", "\N{MINUS SIGN}")
    return power_of_ten(mantissa, power)


def png_of(figure: Figure) -> bytes:
    """Render as PNG on white, at print resolution."""
    return _render(figure, "png", dpi=200)


def svg_of(figure: Figure) -> bytes:
    """Render as SVG on white; the same figure has the same bytes each time."""
    return _render(figure, "svg", dpi=150, metadata={"Date": None, "Creator": "geoswarm"})


def inline_svg(figure: Figure, name: str) -> str:
    """Render as an SVG element for a page: no background, ink and grid in the page's colours, its width.

    Parameters
    ----------
    name
        Prefix of the element's ids, so that several figures can be in one page.
    """
    text = svg_of(figure).decode()
    text = text[text.index("<svg") :].replace("fill: #ffffff", "fill: none", 1)  # the first is that of the figure
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"^<svg ", '<svg role="img" ', text)
    text = re.sub(r'(<svg [^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg [^>]*?) height="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', text)
    text = re.sub(r'(url\(#|href="#)', rf"\1{name}-", text)
    text = re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px", text)
    for colour, role in _ROLES:
        text = text.replace(colour, role)
    return text


def save_figure(figure: Figure, directory: Path, name: str) -> list[Path]:
    """Write ``<name>.png`` and ``<name>.svg``."""
    written = []
    svg = svg_of(figure)  # first, as for a page: the layout is found with the first form
    for suffix, content in (("png", png_of(figure)), ("svg", svg)):
        path = directory / f"{name}.{suffix}"
        path.write_bytes(content)
        written.append(path)
    return written


def _render(figure: Figure, form: str, **options: Any) -> bytes:
    """Render once: a figure does not change any more, and page, PDF and files show the same one."""
    with drawing():
        rendered = _RENDERED.setdefault(figure, {})
        if form not in rendered:
            _lay_out(figure)
            stream = io.BytesIO()
            figure.savefig(stream, format=form, facecolor="white", **options)
            rendered[form] = stream.getvalue()
        return rendered[form]


def _lay_out(figure: Figure) -> None:
    """Find the layout once, with the letters of the page, for every form; :meth:`savefig` would draw all for it."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    engine = figure.get_layout_engine()
    if engine is not None:
        canvas, dpi = FigureCanvasSVG(figure), figure.dpi
        figure.set_dpi(canvas.fixed_dpi)
        engine.execute(figure)
        figure.set_dpi(dpi)
        figure.set_layout_engine(None)

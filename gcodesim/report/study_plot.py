"""Work-precision diagrams of the accuracy study, drawn by matplotlib (extra `plot`)."""

from __future__ import annotations

from typing import Any

from gcodesim.errors import UsageError
from gcodesim.output_file import replacing
from gcodesim.report.study_report import verdict_of

COLUMNS = 2
"""Scenes beside each other; each has a diagram of time and one of work."""

WIDTH, HEIGHT = 4.2, 2.7
"""Of one diagram [inch]."""

LEAST_S = 1e-13
"""Smaller errors are drawn here [s]: an axis of powers has no zero."""

STYLES = {
    "naive float32": ("tab:pink", "v"),
    "naive float64": ("tab:gray", "^"),
    "paper": ("tab:orange", "s"),
    "exhaustive": ("tab:green", "D"),
    "search": ("tab:blue", "o"),
    "search between": ("tab:purple", "*"),
    "directed bound": ("tab:brown", "P"),
}
"""Colour and marker of each method."""


def require_matplotlib() -> None:
    """Say at once, not after a long study, that the plot cannot be drawn.

    Raises:
        UsageError: matplotlib is not installed.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise UsageError("--plot needs matplotlib: pip install 'gcodesim[plot]'") from None


def plot_accuracy(report: dict[str, Any], path: str) -> None:
    """Write a PNG with two diagrams per scene: error against time, and against work."""
    require_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scenes = list(dict.fromkeys(row["scene"] for row in report["rows"]))
    lines = -(-len(scenes) // COLUMNS)
    figure = Figure(figsize=(2 * COLUMNS * WIDTH, lines * HEIGHT + 1), layout="constrained")
    axes = figure.subplots(lines, 2 * COLUMNS, squeeze=False)
    for number, scene in enumerate(scenes):
        rows = [row for row in report["rows"] if row["scene"] == scene]
        at = axes[number // COLUMNS, 2 * (number % COLUMNS) :]
        _draw(at[0], scene, rows, "time [s]", lambda row: row["wall_s"])
        _draw(at[1], scene, rows, "poses + box + triangle tests", _work)
    for unused in axes.flat[2 * len(scenes) :]:
        unused.set_axis_off()
    handles, labels = axes[0, 0].get_legend_handles_labels()
    title = f"Error against run time on {report['cpu']}, {report['date'][:10]}"
    figure.legend(handles, labels, title=title, loc="outside upper center", ncols=len(STYLES))
    FigureCanvasAgg(figure)
    with replacing(path) as file:
        figure.savefig(file, dpi=100, format="png", metadata={"Software": report["schema"]})


def _work(row: dict[str, Any]) -> float:
    return float(max(1.0, row["poses"] + row["box_tests"] + row["triangle_tests"]))


def _draw(axes: Any, scene: str, rows: list[dict[str, Any]], label: str, cost: Any) -> None:
    """One diagram: filled = largest error, hollow = median; misses and false alarms in words.

    Where there is no error to show, because all runs missed or nothing touches, the points lie on
    the setting of the knob instead [s or mm].
    """
    for method, (color, marker) in STYLES.items():
        own = [row for row in rows if row["method"] == method]
        hits = [row for row in own if row["error_max"] is not None]
        most = [max(row["error_max"], LEAST_S) for row in hits]
        median = [max(row["error_median"], LEAST_S) for row in hits]
        costs = [cost(row) for row in hits]
        axes.plot(most, costs, color=color, marker=marker, markersize=4, lw=1, label=method)
        axes.plot(median, costs, color=color, marker=marker, markersize=4, lw=0, mfc="none")
        for row in own:
            _name(axes, row, cost(row), color, marker)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(scene, fontsize=9)
    known = any(row["error_max"] is not None for row in rows)
    axes.set_xlabel("error of first contact [s]" if known else "period [s], tolerance [mm]", size=7)
    axes.set_ylabel(label, size=7)
    axes.tick_params(labelsize=6)


def _name(axes: Any, row: dict[str, Any], cost: float, color: str, marker: str) -> None:
    """Say in red where runs missed, or gave a false alarm; draw what has no error to be drawn."""
    x = _setting(row) if row["error_max"] is None else max(row["error_max"], LEAST_S)
    if row["error_max"] is None:
        axes.plot([x], [cost], color=color, marker=marker, markersize=4, lw=0, mfc="none")
    if row["missed"] or row["false"]:
        axes.annotate(verdict_of(row), (x, cost), fontsize=5, color="red")


def _setting(row: dict[str, Any]) -> float:
    """Setting of the knob: seconds of a period, millimetres of a tolerance."""
    return float(row["setting"] * (1e-3 if "ms" in row["knob"] else 1.0))

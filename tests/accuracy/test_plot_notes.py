"""Remarks on a plot's levels stand where nothing else does."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from particlecli.accuracy.plot_notes import Notes

LEFT = [(x / 10, y) for x in range(5) for y in (0.47, 0.53)]
ABOVE = [(x / 10, 0.53) for x in range(11)]


def noted(points):
    """Where a remark on y = ½ comes to stand over points, and whether it covers none of them."""
    figure = Figure(figsize=(6, 4))
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    for point in points:
        axes.plot(*point, "o")
    Notes(axes, "black").put("a remark on it", 0.5)
    (remark,) = axes.texts
    box = remark.get_window_extent(canvas.get_renderer())
    free = not any(box.contains(*axes.transData.transform(point)) for point in points)
    return remark.xy[0], box.y0 > axes.transData.transform((0, 0.5))[1], free


def test_a_remark_goes_where_no_points_are():
    assert noted([]) == (0.0, True, True)
    assert noted(LEFT) == (1.0, True, True)
    assert noted([*LEFT, *ABOVE]) == (1.0, False, True)


def test_lines_count_between_their_points_too():
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.plot([0, 1], [0.53, 0.53])
    notes = Notes(axes, "black")
    notes.put("under the line", 0.5)
    notes.put("where the first one is not", 0.5)
    assert [remark.xy[0] for remark in axes.texts] == [0.0, 1.0]
    assert all(remark.get_window_extent().y1 < axes.transData.transform((0, 0.5))[1] for remark in axes.texts)

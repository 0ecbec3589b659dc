"""The colours of plots, and what all of them look like."""

INK, GREY, PALE = "#1b1f24", "#6e7781", "#d0d7de"

COLOURS = {
    "euler": "#9bc4e2",
    "midpoint": "#5ba3d0",
    "rk3": "#2a7ab9",
    "rk4": "#084488",
    "symplectic_euler": "#a1d99b",
    "velocity_verlet": "#41ab5d",
    "yoshida4": "#1b7837",
    "composition8": "#00441b",
    "dormand_prince": "#e08214",
    "dop853": "#b35806",
    "implicit_euler": "#d4b9da",
    "implicit_midpoint": "#c994c7",
    "trapezoidal": "#ce1256",
    "tr_bdf2": "#980043",
    "radau_iia": "#67001f",
    "exact": "#cb181d",
}
"""Families in related colours: Runge–Kutta blue, splittings green, adaptive orange, implicit purple."""

PEER_COLOURS = {"SciPy DOP853": "#1b1f24", "SciPy LSODA": "#8c959f"}

STYLE = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "text.color": INK,
    "svg.fonttype": "none",
    "svg.hashsalt": "particlecli",
}


def colour_of(integrator: str) -> str:
    """The colour of an integrator, one of SciPy's among them, as #rrggbb."""
    return PEER_COLOURS.get(integrator) or COLOURS.get(integrator, INK)

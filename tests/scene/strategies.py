"""Hypothesis strategies for scenes as plain data, as they stand in a file."""

from __future__ import annotations

import string
from typing import Any

from hypothesis import strategies as st

Data = dict[str, Any]

numbers = st.one_of(
    st.integers(-1000, 1000),
    st.floats(-1e6, 1e6, allow_nan=False, allow_subnormal=False),
    st.sampled_from([0.1, 1e-30, 1e30, -0.0, 1 / 3]),
)
positive = st.one_of(st.integers(1, 1000), st.floats(1e-9, 1e9))
fraction = st.floats(0, 1, allow_subnormal=False)
vectors = st.lists(numbers, min_size=3, max_size=3)
directions = vectors.filter(lambda vector: any(abs(each) > 1e-6 for each in vector))
names = st.one_of(
    st.sampled_from(["on", "yes", "null", "true", "sparks", "e", "x1", "y"]),
    st.text(string.ascii_letters + "_", min_size=1, max_size=8),
)
colors = st.integers(0, 0xFFFFFF).map(lambda value: f"#{value:06x}")
titles = st.one_of(
    st.text(st.characters(exclude_categories=["Cs"]), max_size=30),
    st.sampled_from(["1e3", "010", "null", "yes", "a: b", "# x", "'", '"', "- a", "{", "1_000", ".5", " a ", "a\nb"]),
)


def distributions(parts: st.SearchStrategy[Any] = positive) -> st.SearchStrategy[Any]:
    """A number, or a distribution that draws positive numbers."""
    pairs = st.lists(positive, min_size=2, max_size=2)
    return st.one_of(
        parts,
        pairs.map(lambda pair: {"uniform": sorted(pair)}),
        positive.map(lambda mean: {"normal": [mean, mean / 10], "min": mean / 2}),
        st.tuples(positive, st.floats(0, 2, allow_subnormal=False)).map(lambda pair: {"log_normal": list(pair)}),
        pairs.map(lambda pair: {"choice": pair, "weights": [1, 2]}),
    )


def optional(**strategies: st.SearchStrategy[Any]) -> st.SearchStrategy[Data]:
    """A mapping in which each key may be absent."""
    return st.fixed_dictionaries({}, optional=strategies)


flow_terms = st.one_of(
    st.fixed_dictionaries({"type": st.just("uniform"), "velocity": vectors}),
    st.fixed_dictionaries({"type": st.just("vortex"), "circulation": numbers}, optional={"axis": directions}),
    st.fixed_dictionaries(
        {"type": st.just("curl_noise"), "length": positive, "speed": positive},
        optional={"octaves": st.integers(1, 8), "lifetime": positive},
    ),
    st.fixed_dictionaries({"type": st.just("abc")}, optional={"amplitudes": vectors, "wave_number": positive}),
    st.fixed_dictionaries({"type": st.just("double_gyre")}, optional={"swing": positive, "length": positive}),
    st.fixed_dictionaries({"type": st.just("taylor_green")}, optional={"viscosity": positive}),
    st.just({"type": "expression", "velocity": ["-y", "sin(x*t)", 0.5]}),
)
shapes = st.one_of(
    st.fixed_dictionaries({"type": st.just("point")}, optional={"center": vectors}),
    st.fixed_dictionaries({"type": st.just("disc"), "radius": positive}, optional={"axis": directions}),
    st.fixed_dictionaries({"type": st.just("box"), "size": st.lists(positive, min_size=3, max_size=3)}),
)
layouts = st.one_of(
    st.fixed_dictionaries(
        {
            "type": st.just("grid"),
            "counts": st.lists(st.integers(1, 9), min_size=3, max_size=3),
            "spacing": positive,
        }
    ),
    st.fixed_dictionaries({"type": st.just("ball"), "radius": positive, "count": st.integers(1, 99)}),
    st.fixed_dictionaries(
        {"type": st.just("lattice"), "size": st.just([1, 0, 3]), "spacing": st.floats(0.1, 2)},
        optional={"pattern": st.just("hexagonal"), "where": st.just("x**2 + z < 4")},
    ),
)
planes = optional(
    point=vectors,
    normal=directions,
    restitution=fraction,
    friction=st.one_of(fraction, st.just({"viscous": 2.0})),
    on_hit=st.sampled_from(["bounce", "stick", "die"]),
)
emitters = st.fixed_dictionaries(
    {"rate": st.one_of(positive, st.sampled_from(["50*t", "where(t < 1, 10, 2)", "abs(sin(t))"]))},
    optional={
        "shape": shapes,
        "bursts": st.lists(st.fixed_dictionaries({"time": positive, "count": st.integers(1, 99)}), max_size=2),
        "direction": optional(axis=directions, spread=st.floats(0, 180, allow_subnormal=False)),
        "speed": distributions(),
        "mass": distributions(),
        "lifetime": distributions(),
        "temperature": distributions(),
    },
)
tolerances = st.one_of(positive, positive.map(lambda value: {"relative": value}))
known = st.one_of(
    st.fixed_dictionaries({"position": vectors.filter(any)}, optional={"velocity": vectors.filter(any)}),
    st.fixed_dictionaries({"energy": positive}),
    st.fixed_dictionaries({"quantity": st.sampled_from(["speed", "x*v - y*u"]), "value": positive}),
)
looks = st.fixed_dictionaries(
    {},
    optional={
        "as": st.sampled_from(["dots", "glow", "streaks", "hidden"]),
        "pixels": positive,
        "color": st.one_of(
            colors,
            st.just("group"),
            st.just({"by": "speed", "map": "viridis", "range": [0, 1]}),
            st.lists(colors, min_size=2, max_size=3).map(lambda map_: {"by": "id", "map": map_, "range": [0, 9]}),
        ),
        "shutter": fraction,
    },
)


@st.composite
def particle_groups(draw: st.DrawFn) -> Data:
    """A group with positions and perhaps other lists, or a layout."""
    velocities = st.lists(st.one_of(distributions(), st.just("-100*x")), min_size=3, max_size=3)
    if draw(st.booleans()):
        return {
            "layout": draw(layouts),
            **draw(optional(mass=distributions(), lifetime=distributions(), velocity=velocities)),
        }
    count = draw(st.integers(1, 4))
    many = {"min_size": count, "max_size": count}
    lists = optional(masses=st.lists(positive, **many), velocities=st.lists(vectors, **many))
    return {"positions": draw(st.lists(vectors, **many)), **draw(lists)}


times = st.one_of(numbers, st.sampled_from(["0.5*t", "1 + sin(2*t)", "t**2"]))
frames = optional(
    translate=st.lists(times, min_size=3, max_size=3),
    rotate=st.fixed_dictionaries({"axis": directions, "angle": times}),
    scale=st.one_of(st.floats(0.1, 10), st.just("1 + 0.1*t")),
)
"""Coordinate frames that ride on the world."""


@st.composite
def scenes(draw: st.DrawFn) -> Data:
    """A valid scene."""
    group_names = draw(st.lists(names, min_size=2, max_size=4, unique=True))
    flow_names = draw(st.lists(names, max_size=2, unique=True))
    some = st.lists(st.sampled_from(group_names), unique=True, max_size=2)
    flow = {"flow": st.sampled_from(flow_names)} if flow_names else {}
    forces = st.one_of(
        st.fixed_dictionaries({"type": st.just("gravity")}, optional={"acceleration": vectors, "on": some}),
        st.fixed_dictionaries({"type": st.just("drag"), "coefficient": positive}, optional={"on": some, **flow}),
        st.just({"type": "force_field", "force": ["-x", "v*t", 2]}),
        st.just({"type": "force_field", "potential": "exp(-(x**2 + y**2))"}),
    )
    answers = st.builds(
        lambda known, tolerance: {"at": 0, "group": group_names[0], "tolerance": tolerance, **known},
        known,
        tolerances,
    )
    data: Data = {
        "duration": draw(positive),
        "particles": {group_names[0]: draw(particle_groups())},
        "emitters": {name: draw(emitters) for name in group_names[1:]},
        "flows": {name: draw(st.lists(flow_terms, max_size=2)) for name in flow_names},
        "frames": draw(st.dictionaries(names, frames, max_size=2)),
        "forces": draw(st.lists(forces, max_size=3)),
        "planes": draw(st.lists(planes, max_size=2)),
        "reference": draw(st.lists(answers, max_size=2)),
        "look": {"groups": {name: draw(looks) for name in draw(some)}},
        "outputs": draw(st.sampled_from([[], [{"type": "video", "path": "a/b.mp4"}, {"type": "frames"}]])),
    }
    extra = optional(
        title=titles,
        seed=st.integers(0, 2**64 - 1),
        fps=positive,
        precision=st.sampled_from(["single", "double"]),
        integrator=optional(type=st.sampled_from(["euler", "rk4", "symplectic_euler"]), dt=positive),
        camera=st.just({"position": [0, 2, 9], "resolution": [640, 480]}),
    )
    return {**data, **draw(extra)}

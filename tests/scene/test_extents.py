import pytest
from pydantic import TypeAdapter

from particlecli.scene.extents import extent
from particlecli.scene.shapes import Layout, Shape

CENTER = [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    [
        ({"type": "point", "center": CENTER}, (1, 2, 3), (1, 2, 3)),
        ({"type": "line", "start": [0, 5, 0], "end": [1, -5, 0]}, (0, -5, 0), (1, 5, 0)),
        ({"type": "disc", "center": CENTER, "radius": 2}, (-1, 2, 1), (3, 2, 5)),
        ({"type": "ring", "center": CENTER, "radius": 2, "axis": [3, 0, 4]}, (-0.6, 0, 1.8), (2.6, 4, 4.2)),
        ({"type": "sphere", "center": CENTER, "radius": 2}, (-1, 0, 1), (3, 4, 5)),
        ({"type": "ball", "center": CENTER, "radius": 2}, (-1, 0, 1), (3, 4, 5)),
        ({"type": "box", "center": CENTER, "size": [2, 0, 4]}, (0, 2, 1), (2, 2, 5)),
    ],
)
def test_shapes(shape: object, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    found = extent(TypeAdapter(Shape).validate_python(shape))
    assert found[0] == pytest.approx(low)
    assert found[1] == pytest.approx(high)


@pytest.mark.parametrize(
    ("layout", "low", "high"),
    [
        ({"type": "grid", "counts": [3, 1, 2], "spacing": 2}, (-2, 0, -1), (2, 0, 1)),
        ({"type": "grid", "counts": [3, 1, 2], "spacing": [1, 1, 4]}, (-1, 0, -2), (1, 0, 2)),
        ({"type": "line", "start": [0, 0, 0], "end": [0, 9, 0], "count": 2}, (0, 0, 0), (0, 9, 0)),
        ({"type": "ball", "radius": 1, "count": 2}, (-1, -1, -1), (1, 1, 1)),
        ({"type": "box", "size": [2, 2, 2], "count": 2}, (-1, -1, -1), (1, 1, 1)),
        ({"type": "lattice", "center": CENTER, "size": [2, 0, 4], "spacing": 1}, (0, 2, 1), (2, 2, 5)),
    ],
)
def test_layouts(layout: object, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    found = extent(TypeAdapter(Layout).validate_python(layout))
    assert found[0] == pytest.approx(low)
    assert found[1] == pytest.approx(high)

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest

from particlecli.scene import reference
from particlecli.scene.integrator import Scheme
from particlecli.scene.language import fields, follow, is_model, members, peel
from particlecli.scene.load import load_scene
from particlecli.scene.look import Luminous, Merging, Solid
from particlecli.scene.model import Scene

ROOT = Path(__file__).parents[2]
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))


def models(annotation: Any = Scene, seen: set[Any] | None = None) -> Iterator[Any]:
    """All models of the language."""
    seen = set() if seen is None else seen
    inner, _ = peel(annotation)
    if is_model(inner) and inner not in seen:
        seen.add(inner)
        yield inner
        for below, _ in fields(inner).values():
            yield from models(below, seen)
    elif not is_model(inner):
        for below in [*members(annotation).values(), *getattr(inner, "__args__", ())]:
            yield from models(below, seen)


def test_readme_is_the_generated_reference() -> None:
    assert (ROOT / "scenes" / "README.md").read_text(encoding="utf-8").strip() == reference.markdown().strip(), (
        "run `particlecli schema --markdown > scenes/README.md`"
    )


def test_every_value_and_every_picture_is_told() -> None:
    told = reference.markdown()
    assert "| anything |" not in told
    for scheme in get_args(Scheme):
        assert f"`{scheme}`" in told
    pictures = set(re.findall(r"pictures/(\w+\.jpg)", told))
    assert pictures == {path.name for path in (ROOT / "scenes" / "pictures").glob("*.jpg")}
    looks = {look.as_ for scene in SCENES for look in load_scene(scene).look.groups.values()}
    assert looks >= {*get_args(Luminous), *get_args(Solid), *get_args(Merging)}


def test_every_key_is_described() -> None:
    found = list(models())
    assert len(found) > 40
    for model in found:
        assert model.__doc__
        for key, (_, field) in fields(model).items():
            if key != "type":
                assert field.description, f"{model.__name__}.{key}"


def test_every_key_is_in_the_reference() -> None:
    text = reference.markdown()
    for model in models():
        for key, (annotation, _) in fields(model).items():
            if key != "type" or len(peel(annotation)[0].__args__) > 1:
                assert f"| `{key}` |" in text, f"{model.__name__}.{key}"
        assert " ".join(model.__doc__.split()) in text


def test_links_lead_somewhere() -> None:
    text = reference.markdown()
    anchors = {title.lower().replace(" ", "-") for title in re.findall(r"^## (.+)$", text, re.MULTILINE)}
    links = set(re.findall(r"\]\(#([^)]+)\)", text))
    assert links
    assert links <= anchors


@pytest.mark.parametrize(
    "row",
    [
        "| `potential` | expression of x, y, z, t |  | U, J; an expression of x, y, z, t; F = −∇U |",
        "| `duration` | number > 0 | **required** | how long it lasts, s |",
        "| `acceleration` | vector | `[0, -9.80665, 0]` | g, m/s² |",
        "| `axis` | direction | `[0, 1, 0]` | normal of the disc |",
        "| `spread` | number from 0 to 180 | `0` | half angle of the cap, degrees; 180: every direction |",
        '| `background` | colour `"#rrggbb"` | `"#05060a"` | colour of the sky |',
        "| `flow` | name |  | the medium; none: at rest |",
        "| `on_hit` | `bounce` `stick` `die` | `bounce` | what becomes of a particle that hits |",
        "| `counts` | 3 whole numbers > 0 | **required** | particles along x, y, z |",
        "| `speed` | number or [distribution](#distribution) | `0` | speed at birth, m/s |",
        "| `integrator` | [integrator](#integrator) |  | scheme and step |",
    ],
)
def test_rows(row: str) -> None:
    assert row in reference.markdown().split("\n")


def test_schema() -> None:
    schema = reference.json_schema()
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["additionalProperties"] is False
    assert schema["required"] == ["duration"]
    look = schema["$defs"]["GroupLook"]["properties"]
    assert "as" in look
    assert "as_" not in look
    assert {"type": "string"} in look["color"]["anyOf"]
    assert schema["$defs"]["Emitter"]["properties"]["rate"]["anyOf"][0] == {"type": ["number", "string"]}
    plane = schema["$defs"]["Plane"]["properties"]
    assert {"type": "number", "minimum": 0} in plane["friction"]["anyOf"]
    for definition in schema["$defs"].values():
        for key, value in definition["properties"].items():
            assert value.get("description") or key == "type"
            assert "title" not in value


def test_following_a_location() -> None:
    spot = follow(("forces", 2, "drag", "coefficient"))
    assert spot.path == ("forces", 2, "coefficient")
    assert spot.description == "k, kg/s"
    assert follow(("emitters", "e", "speed", "uniform", "uniform", 1)).path == (
        "emitters",
        "e",
        "speed",
        "uniform",
        1,
    )
    assert follow(("look", "groups", "a b", "[key]")).path == ("look", "groups", "a b")
    assert [tag for tag, _ in follow(("forces", 0, "gravity")).alternatives][:2] == [
        "gravity",
        "point_gravity",
    ]

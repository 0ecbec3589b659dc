"""A scene that is taken elsewhere takes the files with it that it reads."""

from pathlib import Path

from particlecli.scene.dump import dump_scene
from particlecli.scene.load import load_scene
from particlecli.scene.portable import portable

SCENE = """\
duration: 1
particles:
  dust: {file: data/dust.csv}
  more: {positions: [[0, 0, 0]]}
  rest: {positions: [[0, 0, 1]]}
look:
  groups:
    dust: {as: sprites, sheet: leaf}
    more: {as: sprites, sheet: leaves.png, grid: [2, 1]}
    rest: {as: sprites, sheet: leaves.png, grid: [2, 1]}
"""


def test_data_and_pictures_are_carried_each_once(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "dust.csv").write_text("x,y,z\n0,0,0\n")
    (tmp_path / "leaves.png").write_bytes(b"picture")
    (tmp_path / "scene.yaml").write_text(SCENE)
    carried, attachments = portable(load_scene(tmp_path / "scene.yaml"), "files")
    for each in attachments:
        (tmp_path / "new" / each.name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "new" / each.name).write_bytes(each.source.read_bytes())
    assert [each.name for each in attachments] == ["files/dust.csv", "files/more-sheet.png"]
    (tmp_path / "new" / "scene.yaml").write_text(dump_scene(carried))
    again = load_scene(tmp_path / "new" / "scene.yaml")
    assert again.particles["dust"].file == "files/dust.csv"
    sheets = [look.sheet for look in again.look.groups.values()]
    assert sheets == ["leaf", "files/more-sheet.png", "files/more-sheet.png"]

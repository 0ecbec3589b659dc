from __future__ import annotations

from pathlib import Path

import pytest

from particlecli.errors import OutputError, UsageError
from particlecli.sinks.pending import Pending, within


def test_file_appears_only_when_committed(tmp_path: Path) -> None:
    pending = Pending(tmp_path / "deep" / "er" / "a.txt")
    pending.claim()
    pending.temporary.write_text("new")
    assert not pending.path.exists()
    pending.commit()
    assert pending.path.read_text() == "new"
    assert list(pending.path.parent.iterdir()) == [pending.path]


def test_older_file_stays_until_the_new_one_is_complete(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("old")
    for finish, content in ((Pending.discard, "old"), (Pending.commit, "new")):
        pending = Pending(tmp_path / "a.txt")
        pending.claim()
        pending.temporary.write_text("new")
        assert pending.path.read_text() == "old"
        finish(pending)
        assert pending.path.read_text() == content


def test_folder_replaces_folder(tmp_path: Path) -> None:
    for content in ("first", "second"):
        pending = Pending(tmp_path / "frames", folder=True)
        pending.claim()
        (pending.temporary / content).write_text(content)
        pending.commit()
    assert [entry.name for entry in (tmp_path / "frames").iterdir()] == ["second"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["frames"]


@pytest.mark.parametrize("folder", [False, True])
def test_discard_leaves_nothing(tmp_path: Path, folder: bool) -> None:
    pending = Pending(tmp_path / "deep" / "er" / "a", folder=folder)
    pending.claim()
    pending.discard()
    assert list(tmp_path.iterdir()) == []


def test_discard_keeps_folders_that_others_use(tmp_path: Path) -> None:
    pending = Pending(tmp_path / "deep" / "a")
    pending.claim()
    (tmp_path / "deep" / "other").touch()
    pending.discard()
    assert [entry.name for entry in (tmp_path / "deep").iterdir()] == ["other"]


def test_file_in_place_of_the_folder_is_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(OutputError, match="cannot write"):
        Pending(tmp_path / "out" / "a.txt").claim()


@pytest.mark.parametrize("folder", [False, True])
def test_wrong_kind_in_its_place_is_an_output_error(tmp_path: Path, folder: bool) -> None:
    place = tmp_path / "a"
    place.touch() if folder else place.mkdir()
    with pytest.raises(OutputError, match="of that name"):
        Pending(place, folder=folder).claim()


@pytest.mark.parametrize("path", ["../a", "b/../../a", "/a", ".", "b/..", "link/a"])
def test_outputs_stay_inside_their_folder(tmp_path: Path, path: str) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    with pytest.raises(UsageError, match="not inside"):
        within(folder, path)


def test_paths_inside_are_found_even_before_the_folder_exists(tmp_path: Path) -> None:
    assert within(tmp_path / "out", "b/../c/a") == tmp_path / "out" / "c" / "a"

import pytest

from particlecli.scene.document import unwritten, written
from particlecli.scene.reader import DocumentError, parse


def stopped(text: str) -> tuple[str, int | None, int | None]:
    with pytest.raises(DocumentError) as caught:
        parse(text)
    problem = caught.value.problem
    return problem.message, problem.line, problem.column


def test_values_and_places() -> None:
    root, problems = parse("a: 1\nb:\n  - c: [x, 2.5]\n    'd': \"3\"\n")
    assert root is not None
    assert not problems
    assert root.plain() == {"a": 1, "b": [{"c": ["x", 2.5], "d": "3"}]}
    places = {
        ("a",): (1, 4),
        ("b",): (2, 1),
        ("b", 0): (3, 5),
        ("b", 0, "c"): (3, 8),
        ("b", 0, "c", 1): (3, 12),
        ("b", 0, "d"): (4, 10),
        ("b", 0, "nowhere"): (3, 5),
        ("nowhere",): (1, 1),
    }
    for path, expected in places.items():
        place = root.locate(path)
        assert (place.line, place.column) == expected, path
    assert root.locate(("b", 0, "d"), key=True).column == 5


def test_keys_stay_as_written() -> None:
    root, _ = parse("on: 1\n010: 2\ntrue: 3\n1e3: 4\nnull: 5\n")
    assert root is not None
    assert list(root.plain()) == ["on", "010", "true", "1e3", "null"]


def test_empty() -> None:
    assert parse("") == (None, [])
    assert parse("# nothing\n")[0] is None


def test_aliases_stand_for_what_they_name() -> None:
    root, _ = parse("a: &v [0, -9.81, 0]\nb:\n  c: *v\n")
    assert root is not None
    assert root.plain() == {"a": [0, -9.81, 0], "b": {"c": [0, -9.81, 0]}}
    assert root.locate(("b", "c")).line == 3
    assert root.locate(("b", "c", 1)).line == 1


@pytest.mark.parametrize(
    ("text", "message", "line", "column"),
    [
        ("a: &x [1, *x]", "never end", 1, 11),
        ("a: &x {b: {c: *x}}", "never end", 1, 15),
        ("a: *x", "no &x above", 1, 4),
        ("a: 1\n---\nb: 2\n", "a second document", 2, 1),
        ("[" * 500, "nested deeper", 1, 41),
        ("[" * 100_000, "nested deeper", None, None),
        ("- " * 100_000, "nested deeper", 1, 81),
        ("{a: " * 50 + "1" + "}" * 50, "nested deeper", 1, 161),
        ("a: [1, 2", "list is not closed", 1, 4),
        ("a: {b: 1", "mapping is not closed", 1, 4),
        ("a: 'x", "quote is never closed", 1, 4),
        ("a: b: c", "colon is out of place", 1, 5),
        ("a:\n\tb: 1", "indent with spaces", 2, 1),
        ("a: @b", "cannot begin with @", 1, 4),
        ("a: 1\n  b: 2", "colon is out of place", 2, 4),
        ("a: 1\nb\nc: 2", "colon", 2, 1),
        ("a: \x07", "control character", 1, 4),
        ("a: 1\nb: \0", "not a text file", 2, 4),
        ("x" * 8_000_001, "longer than 8,000,000", None, None),
    ],
)
def test_stops(text: str, message: str, line: int | None, column: int | None) -> None:
    found = stopped(text)
    assert message in found[0]
    if line is not None:
        assert found[1:] == (line, column)


def test_exploding_aliases() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 12)]
    message, line, _ = stopped("\n".join(lines))
    assert "more than 1,000,000 values" in message
    assert line == 6


def test_many_values_are_not_an_explosion() -> None:
    root, _ = parse("a: [" + "0, " * 99_999 + "0]")
    assert root is not None
    assert root.size == 100_002


@pytest.mark.parametrize(
    ("text", "key", "message", "line", "column"),
    [
        ("a: 1\nb: 2\na: 3\n", "a", "stands here twice; the first is in line 1", 3, 1),
        ("b:\n- c: {d: 1, e: 2, d: 3}\n", "b[0].c.d", "stands here twice", 2, 19),
        ("a: !!python/object/apply:os.system [ls]\n", "a", "tag", 1, 4),
        ("a: !!int '3'\n", "a", "tag", 1, 4),
        ("<<: {a: 1}\n", "<<", "merging", 1, 1),
        ("? [a, b]\n: 1\n", "", "a key must be a plain word", 1, 3),
    ],
)
def test_problems_that_can_be_read_past(text: str, key: str, message: str, line: int, column: int) -> None:
    _, problems = parse(text + "z: {y: 1, y: 1}")
    assert len(problems) == 2
    found = problems[0]
    assert (found.key, found.line, found.column) == (key, line, column)
    assert message in found.message


def test_paths_are_written_and_read() -> None:
    path = ("forces", 2, "on", 0)
    assert written(path) == "forces[2].on[0]"
    assert unwritten("forces[2].on[0]") == path
    assert unwritten("") == ()

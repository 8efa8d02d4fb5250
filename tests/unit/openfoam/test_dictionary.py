"""OpenFOAM dictionaries: macros as OpenFOAM resolves them, nothing executed, comments kept."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.openfoam.dictionary import read_dictionary, read_list, set_entry


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_macros_stand_for_what_was_read_before(tmp_path: Path) -> None:
    write(tmp_path, "system/parameters", "gasVelocity 5; seed 3;")
    path = write(
        tmp_path,
        "constant/feed",
        """#include "../system/parameters"
        seed $seed;                 // its own name, from the included file
        vector (0 0 $gasVelocity);
        outer { a 1; inner { b $a; c $:seed; d ${gasVelocity}; } }
        copy { $outer; a 2; }
        """,
    )
    entries = read_dictionary(path)
    assert entries.number("seed") == 3
    assert entries.numbers("vector", 3) == [0, 0, 5]
    inner = entries.sub("outer").sub("inner")
    assert [inner.number(name) for name in "bcd"] == [1, 3, 5]
    assert entries.sub("copy").number("a") == 2
    assert entries.sub("copy").sub("inner").number("b") == 1
    assert "gasVelocity" not in entries
    assert "gasVelocity" in read_dictionary(path, with_included=True)


@pytest.mark.parametrize(
    "text",
    [
        'density #calc "2650*2";',
        'density #codeStream { code #{ system("touch executed"); #}; };',
        "density #eval{ 1 + 1 };",
        "density $nowhere;",
        "density nan;",
        "density inf;",
        "density 1e400;",
        "density -5;",
        "density 0;",
        "density heavy;",
        "density (1 2);",
        "density { a 1; }",
        "denisty 2650;",
        "density;",
        "density 2650",
        "",
        "}",
        "\x00\x01\x02",
        "(" * 100_000,
        "a { " * 2_000,
    ],
)
def test_a_bad_number_is_one_line_that_names_file_and_entry(tmp_path: Path, text: str) -> None:
    path = write(tmp_path, "constant/feed", text)
    with pytest.raises(InputError) as caught:
        read_dictionary(path).number("density", above=0, unit="kg/m3")
    message = str(caught.value)
    assert "feed" in message
    assert "\n" not in message
    assert len(message) < 400
    assert not (tmp_path / "executed").exists()


def test_a_misspelt_entry_is_recognised(tmp_path: Path) -> None:
    path = write(tmp_path, "feed", "denisty 2650; sphericity 1;")
    entries = read_dictionary(path)
    with pytest.raises(InputError, match="denisty: unknown entry, did you mean 'density'"):
        entries.refuse_unknown(["density", "sphericity"])
    with pytest.raises(InputError, match="found 'denisty', did you mean 'density'"):
        entries.number("density")


def test_includes_that_are_missing_or_circular_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "feed", '#include "nowhere"\na 1;')
    with pytest.raises(InputError, match=r"nowhere.*file not found"):
        read_dictionary(path)
    path = write(tmp_path, "feed", '#include "feed"\na 1;')
    with pytest.raises(InputError, match="circle"):
        read_dictionary(path)
    path = write(tmp_path, "feed", '#includeIfPresent "nowhere"\na 1;')
    assert read_dictionary(path).number("a") == 1


def test_what_is_not_a_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not found"):
        read_dictionary(tmp_path / "nowhere")
    with pytest.raises(InputError, match="not a regular file"):
        read_dictionary(tmp_path)
    link = tmp_path / "loop"
    link.symlink_to(link)
    with pytest.raises(InputError):
        read_dictionary(link)
    with pytest.raises(InputError, match="not a regular file"):
        read_dictionary(Path("/dev/zero"))


def test_setting_an_entry_changes_its_line_only(tmp_path: Path) -> None:
    text = "// what a sweep varies\na  5;   // m/s\nb { c (0 0 1); /* keep */ d word; }\n"
    path = write(tmp_path, "parameters", text)
    set_entry(path, "a", "7.5")
    set_entry(path, "b/c", "(1 2 3)")
    set_entry(path, "b/d", "other")
    changed = path.read_text()
    assert "// what a sweep varies" in changed
    assert "// m/s" in changed
    assert "/* keep */" in changed
    entries = read_dictionary(path)
    assert entries.number("a") == 7.5
    assert entries.sub("b").numbers("c", 3) == [1, 2, 3]
    assert entries.sub("b").word("d") == "other"


@pytest.mark.parametrize(
    "value", ["1; b 2", "{ x 1; }", "#calc", "$a", "", "1\n2", "#codeStream { }", "}"]
)
def test_only_one_value_can_be_set(tmp_path: Path, value: str) -> None:
    path = write(tmp_path, "parameters", "a 5;\n")
    with pytest.raises(InputError, match="allowed: one value"):
        set_entry(path, "a", value)
    assert path.read_text() == "a 5;\n"


def test_of_an_entry_that_is_there_twice_the_last_is_set(tmp_path: Path) -> None:
    """OpenFOAM reads the last; foamlib's warning is no line of ours."""
    file = tmp_path / "values"
    file.write_text("n 1;\nm 2;\nn 3;\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        set_entry(file, "n", "4")
    assert file.read_text().split() == ["n", "1;", "m", "2;", "n", "4;"]


def test_setting_what_is_not_there_suggests_what_is(tmp_path: Path) -> None:
    path = write(tmp_path, "parameters", "gasVelocity 5;\n")
    with pytest.raises(InputError, match="did you mean 'gasVelocity'"):
        set_entry(path, "gasVelocty", "5")


def test_patches_of_a_mesh(tmp_path: Path) -> None:
    path = write(tmp_path, "boundary", "2\n(\n a { type patch; }\n b { type wall; }\n)\n")
    assert [entry[0] for entry in read_list(path)] == ["a", "b"]

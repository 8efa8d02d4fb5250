"""The manual tells what the code reads and writes, and its links lead somewhere."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
import typer

from elutria import tables
from elutria.cli import app

ROOT = Path(__file__).resolve().parents[1]
DICTIONARIES = ROOT / "docs/user/dictionaries.md"
OUTPUTS = ROOT / "docs/user/outputs.md"
LAWS = ROOT / "solver/coupling/laws"

READERS = (
    "get", "getOrDefault", "getCheck", "getCheckOrDefault", "getOrAdd", "readIfPresent",
    "readEntry", "readOrDefault", "lookup", "lookupOrDefault", "lookupOrAddDefault", "found",
    "subDict", "subOrEmptyDict", "optionalSubDict", "findDict", "findEntry",
)  # fmt: skip
READ = re.compile(
    rf"(?<!std::)(?<!args\.)\b(?:template\s+)?({'|'.join(READERS)})\s*(?:<[\w:<> ]+>)?\s*\("
)
"""An entry is read; not a standard library's get() and not the command line's options."""

FUNCTION = re.compile(r"\b(\w+)\s*\(((?:[^(){};]|\([^()]*\))*)\)\s*(?:const\s*)?(?:noexcept\s*)?\{")
NAME_PARAMETER = re.compile(
    r"const\s+(?:Foam::)?(?:word|char\s*\*(?:\s*const)?|std::string|string)\s*&?\s*(\w+)"
)

USERS_NAMES = {
    "e.keyword()": "outlets: the products' names",
    "name": "pairs: MATERIAL-MATERIAL; stock's wallLocalSpringSliderDashpot: the walls' names",
    "model + Coeffs": "stock's coefficients of the patch interaction",
    "product": "outlets: the patches of a product",
    "partitionTo_": "the entry partitionTo, whose default it is",
    "source.name()": "a source of constant/fvOptions",
    "reverse": "pairs: the other way round",
    "own": "pairs: either of both",
    "usual": "particleParticle or particleWall",
    "pairModel + Coeffs": "stock's coefficients of the pair model",
    "wallModel + Coeffs": "stock's coefficients of the wall model",
    "m.name": "the feed's record: the materials' names",
    **dict.fromkeys(("folder", "entry", "c.entry", "top"), "the feed's record: what is compared"),
}
"""Entries whose names a case chooses: what the reader is given, and what it is."""

READ_BY_VARIABLE = {"particleParticle", "particleWall"}
"""What `usual` stands for."""


# --- what the C++ reads


@dataclass(frozen=True)
class Reading:
    """An entry as the source reads it, with the default that stands there as a number or a word."""

    entry: str
    default: str | None
    file: str


def sources() -> list[Path]:
    """The files that may read a dictionary; the particle engine knows none."""
    folders = [p for p in (ROOT / "solver").iterdir() if p.is_dir() and p.name != "dem"]
    files = [file for folder in folders for file in folder.rglob("*.[CH]")]
    files += [file for file in LAWS.rglob("*.[hc]pp") if file.parent.name != "tests"]
    return sorted(file for file in files if not file.is_symlink())


def without_comments(text: str) -> str:
    """C++ without comments; strings and line numbers stay."""
    pattern = r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/'

    def keep(match: re.Match[str]) -> str:
        return match[0] if match[0].startswith('"') else "\n" * match[0].count("\n") + " "

    return re.sub(pattern, keep, text, flags=re.S)


def closing(text: str, begin: int) -> int:
    """Place of the bracket that closes the one at `begin`."""
    pairs, depth = {"(": ")", "{": "}"}, 0
    opening, ending = text[begin], pairs[text[begin]]
    in_string = False
    for place in range(begin, len(text)):
        sign = text[place]
        if sign == '"' and text[place - 1] != "\\":
            in_string = not in_string
        if not in_string:
            depth += (sign == opening) - (sign == ending)
        if depth == 0:
            return place
    raise AssertionError(f"no end to {text[begin : begin + 60]}")


def arguments(text: str, begin: int) -> list[str]:
    """The arguments of the call whose bracket opens at `begin`."""
    inside, parts, depth = text[begin + 1 : closing(text, begin)], [""], 0
    for sign in inside:
        depth += (sign in "({<") - (sign in ")}>")
        if sign == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    return [" ".join(part.split()).replace('"', "") for part in parts] if inside.strip() else []


@dataclass(frozen=True)
class Helper:
    """A function that reads the entry which its caller names."""

    place: int  # of the name among the arguments
    default: int | None  # of what is returned where the entry is not there


@cache
def texts() -> dict[Path, str]:
    return {file: without_comments(file.read_text()) for file in sources()}


@cache
def helpers() -> dict[str, Helper]:
    """All functions that hand a parameter of theirs to a reader, or to another such function."""
    found: dict[str, Helper] = {}
    while True:
        before = len(found)
        for text in texts().values():
            for match in FUNCTION.finditer(text):
                parameters = [part.strip() for part in match[2].split(",")]
                body = text[match.end() - 1 : closing(text, match.end() - 1)]
                for place, parameter in enumerate(parameters):
                    name = NAME_PARAMETER.fullmatch(parameter)
                    if name and reads(body, name[1], found):
                        rest = [p.split()[-1] for p in parameters if p]
                        default = next((k for k, p in enumerate(rest) if "fallback" in p), None)
                        if match[1] not in found or default is not None:
                            found[match[1]] = Helper(place, default)
        if len(found) == before:
            return found


def reads(body: str, name: str, known: dict[str, Helper]) -> bool:
    """Whether a function's body reads the entry that the parameter `name` holds."""
    for match in READ.finditer(body):
        given = arguments(body, match.end() - 1)
        if given and given[0] == name:
            return True
    for helper in known:
        for match in re.finditer(rf"\b{helper}\s*\(", body):
            given = arguments(body, match.end() - 1)
            if len(given) > known[helper].place and given[known[helper].place] == name:
                return True
    return False


def calls(text: str) -> Iterator[tuple[int, int, int | None]]:
    """Every reading call: where its bracket opens, and the places of name and default in it."""
    for match in READ.finditer(text):
        default = 1 if "OrDefault" in match[1] else None
        yield match.end() - 1, 0, default
    for name, helper in helpers().items():
        for match in re.finditer(rf"\b{name}\s*\(", text):
            yield match.end() - 1, helper.place, helper.default


@cache
def readings() -> tuple[list[Reading], list[tuple[str, str]]]:
    """What is read by its name, and (file, expression) of what is read by an unknown name."""
    found, unknown = [], []
    for file, text in texts().items():
        shown = str(file.relative_to(ROOT))
        own_names = {
            name[1]
            for match in FUNCTION.finditer(text)
            for parameter in match[2].split(",")
            if (name := NAME_PARAMETER.fullmatch(parameter.strip())) and match[1] in helpers()
        }
        for begin, place, default in calls(text):
            given = arguments(text, begin)
            if len(given) <= place or re.match(r"\s*\)?\s*(?:const\s*)?\{", after(text, begin)):
                continue  # get() of a pointer, or the helper's definition
            call = text[begin : closing(text, begin) + 1]
            literal = re.search(rf'"{re.escape(given[place])}"', call)
            if literal:
                value = given[default] if default is not None and default < len(given) else None
                plain = value is not None and re.fullmatch(r"[\w.+-]+", value) is not None
                named = plain and re.match(r"[\d.]|true$|false$", value or "") is not None
                worded = plain and f'"{value}"' in call
                found.append(Reading(given[place], value if named or worded else None, shown))
            elif given[place] not in own_names and not given[place].startswith("const "):
                unknown.append((shown, given[place]))
    return found, unknown


def after(text: str, begin: int) -> str:
    return text[closing(text, begin) : closing(text, begin) + 40]


# --- what the manual says


@dataclass(frozen=True)
class Row:
    """A table's row: where it stands, the entries it names, and its cells by their headings."""

    section: str
    entries: tuple[str, ...]
    cells: dict[str, str]


def table_rows(page: Path) -> list[Row]:
    """The rows of all tables of a page."""
    rows: list[Row] = []
    section, heading = [""] * 7, list[str]()
    for line in page.read_text().splitlines():
        if title := re.match(r"(#+) (.*)", line):
            level = len(title[1])
            section[level:] = [title[2]] + [""] * (6 - level)
        if not line.startswith("|"):
            heading = []
            continue
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if not heading:
            heading = cells
        elif not set("".join(cells)) <= set("-: "):
            assert len(cells) == len(heading), f"{page.name}: {line}"
            entries = tuple(re.findall(r"`([\w.*-]+)`", cells[0]))
            where = " > ".join(part for part in section[2:] if part)
            rows.append(Row(where, entries, dict(zip(heading, cells, strict=True))))
    return rows


def documented(rows: list[Row], heading: str = "") -> set[str]:
    """What the first column of the tables names; of those with a `heading` if one is given."""
    return {name for row in rows if not heading or heading in row.cells for name in row.entries}


def ours(rows: list[Row]) -> list[Row]:
    """The rows of entries that Elutria's own code reads."""
    return [row for row in rows if not re.search("read by OpenFOAM|by hand", row.section)]


def value_of(text: str) -> str | float:
    """A default as it can be compared: a number, or yes and no for all the words of a switch."""
    text = text.strip("` ")
    words = {"true": "yes", "on": "yes", "false": "no", "off": "no"}
    try:
        return float(text)
    except ValueError:
        return words.get(text, text)


# --- dictionaries


def test_every_entry_that_the_solver_reads_is_in_the_manual() -> None:
    names = {reading.entry for reading in readings()[0]}
    assert len(names) > 60  # the search finds them at all
    told = documented(table_rows(DICTIONARIES)) | documented(table_rows(OUTPUTS))
    missing = {r.entry: r.file for r in readings()[0] if r.entry not in told}
    missing |= {p: law for law, names in size_laws().items() for p in names if p not in told}
    assert missing == {}


def test_an_entry_whose_name_is_no_string_is_one_that_a_case_names() -> None:
    strange = [(file, what) for file, what in readings()[1] if what not in USERS_NAMES
               and not re.search(r"^\w+\.found|^(other|p|point)$", what)]  # fmt: skip
    assert strange == []


def test_the_manual_names_no_entry_that_nothing_reads() -> None:
    read = {reading.entry for reading in readings()[0]} | READ_BY_VARIABLE | python_readings()
    read |= parameters() | {name for names in size_laws().values() for name in names}
    told = documented(ours(table_rows(DICTIONARIES)), "entry")
    assert {entry for entry in told - read if not entry.isupper() and "-" not in entry} == set()


def test_defaults_in_the_manual_are_those_of_the_source() -> None:
    rows = table_rows(DICTIONARIES)
    compared, wrong = 0, []
    for reading in readings()[0]:
        told = [row.cells.get("default", "") for row in rows if reading.entry in row.entries]
        if reading.default is None or not told:
            continue
        compared += 1
        if value_of(reading.default) not in [value_of(text) for text in told]:
            wrong.append((reading.entry, reading.default, told))
    assert compared > 15
    assert wrong == []


def test_every_word_that_an_entry_may_be_is_in_the_manual() -> None:
    told = set(re.findall(r"`(\w+)`", DICTIONARIES.read_text()))
    asked = set()
    for text in texts().values():
        if READ.search(text):
            asked |= set(re.findall(r'[!=]= "([A-Za-z]\w+)"', text))
            asked |= set(re.findall(r'\{\w+::\w+, "(\w+)"\}', text))
    for file in (ROOT / "solver").glob("*/laws/**/*.[Hh]*"):
        asked |= set(re.findall(r'char\* name = "(\w+)"', file.read_text()))
    asked |= set(size_laws())
    assert {"hertzMindlin", "SchillerNaumannDrag", "RosinRammler"} <= asked
    assert len(asked) > 30
    assert asked - told == set()


OWN_DICTIONARIES = {
    "feed": "constant/feed",
    "planes": "planes",
    "material": "materials / NAME",
    "measuredVelocity": "materials / NAME / measuredVelocity",
    "selfInducedVelocity": "selfInducedVelocity",
    "ownWake": "selfInducedVelocity",
    "spreading": "spreading",
    "dragLaw": "subModels / particleForces",
    "cellList": "subModels / cellListCoeffs",
    "contactMaterial": "particle, wall",
    "wallSurface": "surfaces / NAME",
    "contactPair": "particleParticle, particleWall, pairs / A-B",
    "dispersion": "subModels / continuousDispersionRASCoeffs",
    "scenePlan": "system/scenePlan",
}
"""Dictionaries in which the solver refuses what it does not know, and their headings."""


def test_what_the_solver_allows_is_what_the_manual_lists() -> None:
    source = (ROOT / "solver/coupling/foam/ownEntries.C").read_text()
    lists = dict(re.findall(r"case ownDictionary::(\w+):\s+return\s+\{([^}]*)\}", source))
    assert lists.keys() == OWN_DICTIONARIES.keys()
    rows = [row for row in table_rows(DICTIONARIES) if "entry" in row.cells]
    for heading in set(OWN_DICTIONARIES.values()):
        listed = {name for kind, at in OWN_DICTIONARIES.items() if at == heading
                  for name in re.findall(r'"(\w+)"', lists[kind])}  # fmt: skip
        told = documented([r for r in rows if r.section.split(" > ")[-1] == heading])
        assert listed == told - {"phi"}, heading  # phi is of OpenFOAM's nonSphereDrag


def test_the_manual_lists_the_warnings_that_there_are() -> None:
    sources = [p for p in (ROOT / "solver").rglob("*") if p.suffix in {".C", ".H", ".cpp"}
               and not p.is_symlink() and "tests" not in p.parts]  # fmt: skip
    names = {name for file in sources for name in re.findall(
        r'(?:(?:Warnings::add(?:Local)?|table\.warn)\s*\(\{\s*|warnings\.push_back\(\{'
        r'|\bWarning(?: \w+)?\{)"(\w+)"', file.read_text())}  # fmt: skip
    for file in product_modules():
        names |= set(re.findall(r'Warned\(\s*name="(\w+)"', file.read_text()))
    assert len(names) > 15
    assert names == documented(table_rows(OUTPUTS), "kind")


def python_readings() -> set[str]:
    """Entries that the tool reads, by the methods of its Dictionary."""
    calls = r'\b(?:number|numbers|word|words|sub|raw)\(\s*"(\w+)"'
    return {name for file in product_modules() for name in re.findall(calls, file.read_text())}


def size_laws() -> dict[str, list[str]]:
    """The size laws of a feed, and their parameters, which are entries of its dictionary."""
    rows = re.findall(r'\{"(\w+)", \{([^}]*)\},', (LAWS / "SizeLaws.cpp").read_text())
    assert len(rows) > 3
    return {name: re.findall(r'"(\w+)"', parameters) for name, parameters in rows}


def parameters() -> set[str]:
    """The default case's system/simulationParameters."""
    text = (ROOT / "cases/column/system/simulationParameters").read_text()
    return set(re.findall(r"^(\w+)\s+\S", re.sub(r"FoamFile\s*\{[^}]*\}", "", text), re.M))


def test_every_entry_that_the_tool_reads_is_in_the_manual() -> None:
    assert len(python_readings()) > 30
    assert python_readings() - documented(table_rows(DICTIONARIES)) == set()


def test_every_parameter_of_the_default_case_is_in_the_manual() -> None:
    rows = [r for r in table_rows(DICTIONARIES) if r.section.startswith("system/simulationPara")]
    assert documented(rows) == parameters()


# --- outputs


def columns() -> set[str]:
    """The columns of all csv files, the solver's and the tool's."""
    headers = [re.findall(r'"(time_s,[^;]*)";', text) for text in texts().values()]
    solvers = re.sub(r'["\s]', "", ",".join(h for found in headers for h in found)).split(",")
    tools = [name for table in vars(tables).values() if isinstance(table, tuple) for name in table]
    assert {"time_s", "residence_time_s"} <= set(solvers)
    assert {"d50_m", "cut_size_m", "aic"} <= set(tools)
    return {*solvers, *tools}


def test_every_column_that_is_written_is_in_the_manual() -> None:
    assert columns() - documented(table_rows(OUTPUTS)) == set()


def test_the_manual_names_no_column_that_nothing_writes() -> None:
    told = documented(table_rows(OUTPUTS), "column")
    assert len(told) > 30
    assert told - columns() == set()


def test_the_ledger_has_the_keys_that_the_manual_tells() -> None:
    sources = [text for file, text in texts().items() if file.name in ("Ledger.C", "Account.C")]
    keys = set(re.findall(r'\\"(\w+)\\":', "".join(sources)))
    assert keys == documented(table_rows(OUTPUTS), "key")


def test_every_line_that_programs_read_in_the_log_is_in_the_manual() -> None:
    page = OUTPUTS.read_text()
    lines = {
        " ".join(line.split()[:3])
        for text in texts().values()
        for line in re.findall(r'"(?:\\n)?(elutria: [a-z ]+)', text)
    }
    assert len(lines) > 4
    assert {line for line in lines if f"`{line}" not in page} == set()


def product_modules() -> list[Path]:
    return sorted((ROOT / "tools/elutria").rglob("*.py"))


# --- commands


def commands() -> list[tuple[str, list[str]]]:
    """(page, words) of every elutria command in a page's code blocks."""
    found = []
    for page in pages():
        blocks = re.findall(r"^\s*```\n(.*?)^\s*```", page.read_text(), re.S | re.M)
        for line in "\n".join(blocks).splitlines():
            if re.match(r"\s*elutria [a-z]+( |$)", line):
                found.append((page.name, shlex.split(line, comments=True)))
    return found


def test_commands_in_the_texts_have_the_options_that_they_use() -> None:
    group = typer.main.get_command(app)
    known = group.commands  # type: ignore[attr-defined]
    assert len(commands()) > 10
    for page, words in commands():
        assert words[1] in known, (page, words)
        options = {"--help", "--debug"}
        options |= {name for p in known[words[1]].params for name in p.opts}
        assert {word for word in words[2:] if word.startswith("--")} <= options, (page, words)


# --- links, and how the pages are written


def pages() -> list[Path]:
    found = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "cases").rglob("*.md")]
    return sorted(found)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(), re.M)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).lower() for title in titles]
    return {re.sub(r"[^\w\- ]", "", title).strip().replace(" ", "-") for title in plain}


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings_that_are_there(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M)
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        name, _, anchor = target.partition("#")
        if "://" in name or name.startswith("mailto:"):
            continue
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
            broken.append(target)
    assert broken == []


def test_every_page_of_the_manual_is_linked_from_an_index() -> None:
    for index in (ROOT / "docs/user/index.md", ROOT / "docs/developers/index.md"):
        linked = re.findall(r"\]\(([^)#\s]+)", index.read_text())
        pages_beside = {page.name for page in index.parent.glob("*.md")} - {"index.md"}
        assert pages_beside <= set(linked), index


def test_paths_that_the_texts_name_are_there() -> None:
    """Folders and files in code marks, such as `solver/dem`, in pages written by hand."""
    paths = r"`((?:solver|tools|tests|cases|etc|docs)/[\w./-]+)`"
    gone = [
        f"{page.relative_to(ROOT)}: {path}"
        for page in pages()
        if not {"bench", "verification"} & set(page.parts)
        for path in re.findall(paths, page.read_text())
        if not (ROOT / path).exists()
    ]
    assert gone == []


def test_architecture_says_what_each_library_is_for() -> None:
    project = (ROOT / "tools/pyproject.toml").read_text()
    needed = re.findall(r'^    "([\w-]+)>=', project, re.M)
    page = (ROOT / "ARCHITECTURE.md").read_text()
    assert len(needed) > 5
    assert [name for name in needed if not re.search(rf"\b{name}\b", page)] == []


def test_the_version_to_cite_is_the_tools() -> None:
    project = (ROOT / "tools/pyproject.toml").read_text()
    version = re.search(r'^version = "(.+)"', project, re.M)
    cited = re.search(r"^version: (.+)", (ROOT / "CITATION.cff").read_text(), re.M)
    noted = re.findall(r"^## \[([\d.]+)\] - (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.M)
    released = re.search(r"^date-released: (.+)", (ROOT / "CITATION.cff").read_text(), re.M)
    assert version and cited and released
    assert (version[1], cited[1]) == (noted[0][0], noted[0][0])
    assert released[1] == noted[0][1]


def test_the_checks_before_a_commit_are_those_of_the_tests() -> None:
    config = (ROOT / ".pre-commit-config.yaml").read_text()
    assert re.findall(r"repo: (\S+)", config) == ["local"]
    entries = re.findall(r"entry: (.+)", config)
    assert any("-m ruff check tools tests" in entry for entry in entries)
    named = {word for entry in entries for word in entry.split() if word.startswith("tests/")}
    assert named == {"tests/test_setup_repository.py", "tests/test_setup_documentation.py"}
    assert all((ROOT / name).is_file() for name in named)


def test_names_of_code_in_the_texts_are_there() -> None:
    """Types, functions and constants in code marks, in the pages for developers."""
    files = [*(ROOT / "solver").rglob("*"), *(ROOT / "tools").rglob("*.py")]
    code = {".C", ".H", ".cpp", ".hpp", ".inl", ".py"}
    words = {file.name for file in (ROOT / "cases").rglob("*")}
    for file in files:
        if file.suffix in code and not file.is_symlink():
            words |= set(re.findall(r"\w+", file.read_text()))
    texts_for_developers = [ROOT / "ARCHITECTURE.md", *(ROOT / "docs/developers").glob("*.md")]
    gone, seen = [], 0
    for page in texts_for_developers:
        for marked in re.findall(r"`([A-Za-z_][\w:]*)(?:\([^`]*\))?`", page.read_text()):
            for name in marked.split("::"):
                seen += 1
                if re.search(r"[a-z][A-Z]|^[A-Z][a-z]", name) and name not in words:
                    gone.append(f"{page.name}: {name}")
    assert seen > 40
    assert gone == []


def test_tests_that_the_pages_name_are_there() -> None:
    """FILE::TEST in the table of what is held by which test; ::TEST is in the file before it."""
    missing, seen, tests = [], 0, ""
    page = (ROOT / "docs/developers/testing.md").read_text()
    for file, name in re.findall(r"`([\w/]+\.py)?(?:::(test_\w+))?`", page):
        if file:
            path = ROOT / ("tests/cases/" if "/" not in file else "") / file
            tests = path.read_text()
        if name:
            seen += 1
            missing += [] if f"def {name}(" in tests else [name]
    assert seen > 30
    assert missing == []

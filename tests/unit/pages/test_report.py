"""The report: complete without a network and without scripts, and true to the tables."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from elutria import tables
from elutria.cli import main
from elutria.errors import InputError
from elutria.files import read_csv
from elutria.output.results import read_results
from elutria.pages import report
from elutria.pages.browser import find_browser, run_browser
from elutria.pages.report import write_report
from elutria.pages.runs import find_runs
from tests.support.made_results import make_results


class Page(HTMLParser):
    """What a page refers to, and the cells of its tables by section."""

    def __init__(self, file: Path):
        super().__init__()
        self.outside: list[str] = []
        self.cells: dict[str, list[str]] = {}
        self.titles: list[str] = []
        self.section = ""
        self.open: list[str] = []
        self.feed(file.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {name: value or "" for name, value in attrs}
        self.section = named.get("id", self.section) if tag == "section" else self.section
        self.open.append(tag)
        if tag == "td":
            self.cells.setdefault(self.section, []).append("")
        for name in ("src", "href", "xlink:href", "data", "action"):
            if name in named and not named[name].startswith("#"):
                self.outside.append(f"{tag} {named[name]}")

    def handle_endtag(self, tag: str) -> None:
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if "td" in self.open[-2:]:
            self.cells[self.section][-1] += data.strip()
        if self.open[-1:] == ["title"]:
            self.titles.append(data)


def test_the_report_needs_nothing_else(made: Path, tmp_path: Path) -> None:
    file = write_report(made, tmp_path / "page.html")
    text = file.read_text()
    assert Page(file).outside == []
    assert re.findall(r"(?:url|@import)\((?!#)[^)]*", text) == []
    namespaces = {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}
    assert set(re.findall(r"https?://[^\"' <)]+", text)) <= namespaces
    assert file.stat().st_size < 2_000_000


def test_the_report_says_what_the_tables_say(made: Path, tmp_path: Path) -> None:
    page = Page(write_report(made, tmp_path / "page.html"))
    for row in read_csv(made / "summary.csv", tables.SUMMARY):
        for name in ("d25_m", "d50_m", "d75_m"):
            assert f"{row[name] * 1e6:.4g}" in page.cells["answer"]
        assert f"{100 * row['fines_yield']:.1f}" in page.cells["answer"]
        # the model's error has a cell of its own, after that of chance's interval
        interval = f"{row['d50_low_m'] * 1e6:.4g} .. {row['d50_high_m'] * 1e6:.4g}"
        after = page.cells["answer"][page.cells["answer"].index(interval) + 1]
        assert after == f"{100 * row['d50_model_error']:.1f}" == "5.3"
    for row in read_csv(made / "products.csv", tables.PRODUCTS):
        assert f"{1e3 * row['mass_kg']:.4g}" in page.cells["products"]
        assert f"{100 * row['recovery']:.1f}" in page.cells["products"]
        assert f"{row['d90_m'] * 1e6:.4g}" in page.cells["products"]
    ledger = json.loads((made / "U6/postProcessing/ledger.json").read_text())
    assert f"{ledger['total']['outlets']['coarse']['number']}" in page.cells["ledger"]
    assert page.cells["ledger"][page.cells["ledger"].index("U6") + 1] == "800"
    assert "12.5" in " ".join(page.cells["repeat"])
    assert "quartz" in page.cells["asked"]


def test_every_measured_class_has_its_words(made: Path, tmp_path: Path) -> None:
    page = Page(write_report(made, tmp_path / "page.html"))
    words = [title for title in page.titles if "To coarse" in title]
    rows = read_csv(made / "partition.csv", tables.PARTITION)
    rows = [row for row in rows if row["material"] == "quartz"]
    changing = [row for row in rows if 0.01 < row["partition_to_coarse"] < 0.99
                and row["ci_high"] - row["ci_low"] < 0.5]  # fmt: skip
    assert len(changing) > 6
    for row in changing:
        (own,) = [title for title in words if title.startswith(f"{row['gas_velocity_m_s']:g} m/s")
                  and f": {row['diameter_low_m'] * 1e6:.4g} to " in title]  # fmt: skip
        assert f"To coarse {100 * row['partition_to_coarse']:.1f} %" in own


def test_words_stand_on_their_own_mark(made: Path, tmp_path: Path) -> None:
    """The higher a mark in the picture, the larger the share that its words tell."""
    text = write_report(made, tmp_path / "page.html").read_text()
    marks = re.findall(r'<use [^>]*?y="([\d.]+)"[^>]*><title>5 m/s[^<]*?To coarse ([\d.]+) %', text)
    assert len(marks) > 3
    height = np.array([float(y) for y, _ in marks])
    share = np.array([float(share) for _, share in marks])
    slope, offset = np.polyfit(share, height, 1)
    assert slope < 0
    assert np.abs(slope * share + offset - height).max() < 0.2  # points of 1/72 inch


def test_what_differs_between_runs_is_said_of_which(made: Path, tmp_path: Path) -> None:
    cells = Page(write_report(made, tmp_path / "page.html")).cells["solver"]
    place = cells.index("the load changes the gas by 6 %")
    assert cells[place + 1] == "U6"
    assert cells[cells.index("friction") + 1] == "all"


def test_warnings_of_runs_are_data_or_the_plans(results: Path, tmp_path: Path) -> None:
    plan = results / "U5/postProcessing/plan.json"
    plan.write_text(plan.read_text().replace('"warnings": []', '"warnings": ["too <few> parcels"]'))
    warning = {
        "name": "x",
        "what": "mesh",
        "how_much": "3 cells",
        "what_to_set": "more",
        "times": 4,
    }
    (results / "U6/warnings.json").write_text(json.dumps([warning]))
    text = write_report(results, tmp_path / "page.html").read_text()
    assert 'too &lt;few&gt; parcels <span class="faint">(U5)' in text
    assert 'mesh: 3 cells; more (4 times) <span class="faint">(U6)' in text
    (results / "U6/warnings.json").write_text('{"no": "list"}')
    with pytest.raises(InputError, match=r"U6/warnings\.json: is not a list of warnings"):
        write_report(results, tmp_path / "page.html")


def test_the_command_makes_the_same_runs(made: Path, tmp_path: Path) -> None:
    text = write_report(made, tmp_path / "page.html").read_text()
    assert (
        "<pre>elutria sweep column --velocity 5,6,7 "
        "--set system/simulationParameters:particles=800 --to results/column</pre>" in text
    )


def test_settings_that_are_not_known_are_not_made_up(results: Path, tmp_path: Path) -> None:
    (results / "U6/elutria.json").write_text('{"case": "column", "inputs": "0"}')
    text = write_report(results, tmp_path / "page.html").read_text()
    assert "settings were not recorded" in text
    assert "elutria sweep" not in text


def test_a_run_alone_has_a_report(results: Path, tmp_path: Path) -> None:
    run = results / "U6"
    main(["classify", str(run)])
    page = Page(write_report(run, tmp_path / "page.html"))
    assert page.cells["answer"][0] == "6 m/s"


def test_results_without_their_runs_are_code_2(results: Path, tmp_path: Path) -> None:
    for run in results.glob("U*"):
        shutil.rmtree(run)
    with pytest.raises(InputError, match="none of the runs"):
        write_report(results, tmp_path / "page.html")


def test_runs_are_found_whose_velocity_has_more_digits_than_the_tables(tmp_path: Path) -> None:
    folder = make_results(tmp_path / "thirds", [16 / 3, 17 / 3], particles=200)
    results = read_results(folder)
    runs = find_runs(folder, results.settings)
    assert [run.name for run in runs] == ["U5.33333", "U5.66667"]
    assert [run.setting for run in runs] == results.settings.all


def test_without_a_browser_one_line_says_so(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    main(["report", str(made), "--to", str(tmp_path / "page.html"), "--pdf"])
    assert capsys.readouterr().err.strip().count("no PDF") == 1
    assert (tmp_path / "page.html").is_file()


@pytest.fixture
def browser() -> str:
    program = find_browser()
    if program is None:
        pytest.skip("no Chromium on PATH; on Debian: apt-get install chromium")
    return program


@pytest.mark.slow
def test_a_browser_shows_and_prints_it(browser: str, made: Path, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    main(["report", str(made), "--to", str(file), "--pdf"])
    assert (tmp_path / "page.pdf").read_bytes()[:5] == b"%PDF-"
    shown = run_browser(browser, ["--dump-dom", file.as_uri()]).stdout
    assert re.findall(r'aria-pressed="true">([^<]*)', shown) == ["5 m/s", "6 m/s", "7 m/s"]


def test_large_numbers_and_what_is_not_known_can_be_read() -> None:
    assert report.number(float("nan")) == report.number(None) == "-"
    assert report.number(1234567.0) == "1,234,567"
    assert report.number(float("inf")) == "open"
    assert report.micrometres(0.000123456) == "123.5"

"""Tables of results come from stored reports, and the pages are up to date."""

import json
import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
TABLES = runpy.run_path(str(DOCS / "results_tables.py"))
PAGE = (
    "# A\n<!-- results one: name={name} | rate={rate:.1f} % -->\nold\n<!-- end of results -->\nB\n"
)


def test_pages_hold_the_tables_of_the_stored_reports():
    named = []
    for page in DOCS.rglob("*.md"):
        text = page.read_text()
        assert TABLES["with_tables"](text) == text, f"run python docs/results_tables.py: {page}"
        for match in TABLES["BLOCK"].finditer(text):
            named += [name for name, _ in TABLES["reports_of"](match[2])]
    assert sorted(set(named)) == sorted(file.stem for file in (DOCS / "results").glob("*.json"))


def test_stored_reports_hold_no_paths_of_the_machine():
    for file in (DOCS / "results").glob("*.json"):
        content = json.loads(file.read_text())
        assert {"command", "date", "report"} == set(content)
        assert content["report"]["machine"]
        assert not [word for word in ("/tmp", "/home", "/work") if word in file.read_text()]


def test_table_is_written_from_the_report(tmp_path):
    rows = [{"name": "a", "rate": 12.34}, {"name": "b", "rate": 100.0}]
    report = {"seed": 7, "machine": "a machine", "out": "/tmp/x", "rows": rows}
    file = TABLES["store"]("one", "eyehand evaluate", report, tmp_path)
    date = json.loads(file.read_text())["date"]
    text = TABLES["with_tables"](PAGE, tmp_path)
    assert "| name | rate |\n| --- | --- |\n| a | 12.3 % |\n| b | 100.0 % |\n" in text
    assert f"`eyehand evaluate`, seed 7, {date}, a machine." in text
    assert "old" not in text
    assert TABLES["with_tables"](text, tmp_path) == text


def test_several_reports_make_one_table_with_labels(tmp_path):
    files = []
    for label, rate in (("first", 1.0), ("second", 2.0)):
        file = tmp_path / f"{label}.json"
        file.write_text(json.dumps({"seed": 7, "rows": [{"name": "a", "rate": rate}]}))
        files.append(f"{label}={file}")
    report = TABLES["joined_report"](files)
    assert [(row["label"], row["rate"]) for row in report["rows"]] == [("first", 1), ("second", 2)]
    assert report["seed"] == 7


def test_one_table_joins_stored_reports_and_names_the_command_of_each(tmp_path):
    for name, rate in (("one", 1.0), ("two", 2.0)):
        rows = [{"name": "a", "rate": rate}, {"name": "b", "rate": 9.0}]
        TABLES["store"](name, f"eyehand {name}", {"rows": rows}, tmp_path)
    page = "<!-- results one=first, 5° + two=second where name=a: data={label} | %={rate:.0f} -->\n"
    text = TABLES["with_tables"](page + "<!-- end of results -->\n", tmp_path)
    assert "| data | % |\n| --- | --- |\n| first, 5° | 1 |\n| second | 2 |\n" in text
    assert "- first, 5°: `eyehand one`," in text
    assert "- second: `eyehand two`," in text


def test_a_report_of_pytest_benchmark_gives_a_row_per_test(tmp_path):
    stats = {"median": 0.02, "q1": 0.019, "q3": 0.025}
    file = tmp_path / "bench.json"
    file.write_text(json.dumps({"benchmarks": [{"name": "test_benchmark_read", "stats": stats}]}))
    (row,) = TABLES["joined_report"]([str(file)])["rows"]
    assert row == {"name": "read", "median_ms": 20.0, "q1_ms": 19.0, "q3_ms": 25.0}


def test_column_without_a_field_is_an_error(tmp_path):
    TABLES["store"]("one", "eyehand", {"rows": [{"name": "a"}]}, tmp_path)
    with pytest.raises(KeyError, match="rate"):
        TABLES["with_tables"](PAGE, tmp_path)


def test_rows_are_chosen_by_a_field_and_unknown_values_are_dashes(tmp_path):
    rows = [{"name": "a", "rate": 1.0}, {"name": "b", "rate": None}, {"name": "b"}]
    TABLES["store"]("one", "eyehand", {"rows": rows}, tmp_path)
    text = TABLES["with_tables"](
        PAGE.replace("results one:", "results one where name=b:"), tmp_path
    )
    assert "| --- | --- |\n| b | - % |\n| b | - % |\n" in text
    text = TABLES["with_tables"](
        PAGE.replace("results one:", "results one where name=b or a:"), tmp_path
    )
    assert "| --- | --- |\n| a | 1.0 % |\n| b | - % |\n| b | - % |\n" in text

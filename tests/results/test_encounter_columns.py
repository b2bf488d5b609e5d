"""The list of encounter columns, and what follows from it."""

from __future__ import annotations

import pytest

from porous_swim.results import encounter_page
from porous_swim.results.encounter_columns import COLUMNS, Column, Least, Sum, check_columns
from porous_swim.results.tables import ENCOUNTERS_SCHEMA

# as files have them
NAMES = """
swimmer colloid image_x image_y image_z start_time end_time start_censored end_censored contact_time wall_push
winding signed_winding entry_x entry_y entry_z exit_x exit_y exit_z entry_ex entry_ey entry_ez exit_ex exit_ey exit_ez
entry_pitch exit_pitch release_time release_pitch release_winding escape_pitch_time min_height mean_height max_height
"""


def test_files_have_their_columns_in_the_order_of_always():
    assert ENCOUNTERS_SCHEMA.names == NAMES.split()
    types = {str(field.type): field.name for field in reversed(list(ENCOUNTERS_SCHEMA))}
    assert types == {"int32": "swimmer", "double": "start_time", "bool": "start_censored"}


def test_the_page_has_the_table_of_the_list():
    text = encounter_page.PAGE_FILE.read_text(encoding="utf-8")
    assert encounter_page.page(text) == text, "run: python -m porous_swim.results.encounter_page"
    row = next(line for line in text.splitlines() if line.startswith("| `signed_winding`"))
    assert [cell.strip() for cell in row.split("|")][3:6] == ["turns", "number", "in three dimensions"]


def test_a_page_without_the_marks_is_left_alone():
    with pytest.raises(ValueError, match="lacks the lines"):
        encounter_page.page("# Statistics\n")


def test_every_column_says_what_it_is_and_where_it_is_null():
    for column in COLUMNS:
        assert column.meaning.endswith("."), column.name
        assert column.null == "" or column.null.startswith(("where ", "in ")), column.name


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ([Column("a", "", Sum("a"), ""), Column("a", "", Sum("b"), "")], "two columns .* have the name 'a'"),
        ([Column("a", "", Sum("x"), ""), Column("b", "", Least("x"), "")], "two rows of the kernel .* the name 'x'"),
        ([Column("a", "", Sum("x"), ""), Column("b", "", Sum("x_rest"), "")], "two rows .* the name 'x_rest'"),
    ],
)
def test_two_columns_or_rows_of_one_name_are_refused(columns, message):
    with pytest.raises(ValueError, match=message):
        check_columns(columns)

"""How a run compares with another one: tables, classes, and references that are refused."""

from __future__ import annotations

import gzip
import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from ptl.cli.verify import command
from ptl.errors import UserError
from ptl.files import manifest
from ptl.files.comparison import KEPT, PUBLISHED, NothingToCompareError, compare, first_difference, reference

CLAIMS = "id,class,holds_when\nE1,in part,\nE2,under some readings,on task F\n"
TABLE = "steps,mean,text\n8600,0.887123,90 [0.25]\n"


def seal(folder: Path, config: dict | None = None) -> None:
    """Write the manifest of a report folder, as the run that made it does."""
    products = [path for path in folder.rglob("*.*") if path.name != manifest.MANIFEST]
    text = manifest.to_json(manifest.build(products, folder, config or {"run": "tiny", "measures": {"window": 3}}, {}))
    (folder / manifest.MANIFEST).write_text(text)
    made = folder.parent.parent / "results" / folder.name / "made.json"
    made.parent.mkdir(parents=True, exist_ok=True)
    made.write_text(text)


def make(folder: Path) -> Path:
    """A small report folder with a manifest."""
    folder.mkdir(parents=True)
    (folder / "claims.csv").write_text(CLAIMS)
    (folder / "a.csv").write_text(TABLE)
    (folder / "a.svg").write_text('<path d="M 1.5 2"/>')
    seal(folder)
    return folder


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    return make(tmp_path / "here/reports/published")


@pytest.fixture
def theirs(tmp_path: Path) -> Path:
    return make(tmp_path / "there/reports/published")


def test_compressed_tables_are_compared_by_what_they_contain(mine, theirs):
    for folder, level in ((mine, 1), (theirs, 9)):  # as if by other versions of zlib
        (folder / "b.csv.gz").write_bytes(gzip.compress(TABLE.encode() * 9, level, mtime=0))
        seal(folder)
    assert compare(mine, reference(str(theirs), mine)).lines[1].startswith("  tables: 2 equal, 1 within")
    for content in (gzip.compress(TABLE.replace("8600", "8601").encode()), b"no gzip"):
        (mine / "b.csv.gz").write_bytes(content)
        seal(mine)
        assert not compare(mine, reference(str(theirs), mine)).agrees


def test_equal_runs_agree(mine, theirs):
    found = compare(mine, reference(str(theirs / manifest.MANIFEST), mine))
    assert found.agrees
    assert found.lines[1:] == [
        "  tables: 2 equal, 0 within the tolerance, 0 different",
        "  drawings and pages: 1 equal, 0 with different bytes (not judged)",
        "  classes of claims: 2 of 2 equal",
    ]


@pytest.mark.parametrize(
    ("ours", "difference"),
    [
        (TABLE.replace("0.887123", "0.887124"), ""),
        (TABLE.replace("0.887123", "0.88712"), "line 2, column 2: 0.887123, here 0.88712"),
        (TABLE.replace("0.887123", "0.887125"), "line 2, column 2: 0.887123, here 0.887125"),
        (TABLE.replace("0.887123", "-0.887123"), "line 2, column 2: 0.887123, here -0.887123"),
        (TABLE.replace("0.25", "0.26"), ""),
        (TABLE.replace("90 [", "91 ["), "line 2, column 3: 90 [0.25], here 91 [0.25]"),
        (TABLE.replace("8600", "8601"), "line 2, column 1: 8600, here 8601"),
        (TABLE.replace("8600", ""), "line 2, column 1: 8600, here "),
        (TABLE.replace("mean", "Mean"), "line 1, column 2: mean, here Mean"),
        (TABLE + "1,2,x\n", "line 3, column 1: no cell, here 1"),
        (TABLE.replace(",90 [0.25]", ""), "line 2, column 3: 90 [0.25], here no cell"),
        (TABLE + '"', "no table"),
        ("\xff", "no table"),
    ],
)
def test_only_the_last_digit_of_fractions_may_differ(ours, difference):
    assert first_difference(ours.encode("latin-1"), TABLE.encode()) == difference


def test_numbers_and_classes_decide_and_drawings_do_not(mine, theirs):
    (mine / "a.svg").write_text("<svg/>")
    (mine / "a.csv").write_text(TABLE.replace("0.887123", "0.887122"))
    found = compare(mine, reference(str(theirs), mine))
    assert found.agrees
    assert "tables: 1 equal, 1 within the tolerance, 0 different" in str(found)
    assert "1 with different bytes (not judged)" in str(found) and "pages with different bytes: a.svg" in str(found)
    (mine / "a.csv").write_text(TABLE.replace("8600", "8601"))
    found = compare(mine, reference(str(theirs), mine))
    assert not found.agrees and "different tables: a.csv (line 2, column 1: 8600, here 8601)" in str(found)


def test_classes_settings_and_missing_products_are_named(mine, theirs):
    (mine / "claims.csv").write_text(CLAIMS.replace("on task F", "on \x1b[31m"))
    seal(mine, {"run": "tiny", "measures": {"window": 10}})
    (mine / "a.svg").unlink()
    found = compare(mine, reference(str(theirs), mine))
    assert not found.agrees
    text = str(found)
    assert "missing: a.svg" in text and "changed settings: measures.window (3, here 10)" in text
    assert "classes of claims: 1 of 2 equal" in text
    assert r"changed classes: E2 (under some readings: on task F, here under some readings: on \x1b[31m)" in text
    assert "where to look: 'git diff" in text


def test_claims_that_cannot_be_read_have_no_class(mine, theirs):
    (mine / "claims.csv").write_bytes(b"\xff")
    assert "changed classes: E1 (in part, here -), E2" in str(compare(mine, reference(str(theirs), mine)))


def test_a_reference_that_is_no_ordinary_file_is_never_waited_for(mine, theirs):
    (mine / "a.csv").write_text("else\n")
    (theirs / "a.csv").unlink()
    (theirs / "a.csv").symlink_to("/dev/zero")
    assert "a.csv (no table in the other run)" in str(compare(mine, reference(str(theirs), mine)))


def test_a_run_is_never_compared_with_itself(mine, tmp_path, monkeypatch):
    with pytest.raises(UserError, match="would be compared with itself"):
        reference(str(mine / "../published"), mine)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=f"neither git's HEAD nor {KEPT} holds the published products"):
        reference(PUBLISHED, mine)


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch) -> Path:
    """A git checkout whose HEAD holds published products; nothing was run in it yet."""
    folder = make(tmp_path / "checkout/reports/published")
    root = folder.parent.parent
    shutil.rmtree(root / "results")
    monkeypatch.chdir(root)
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for arguments in (["init", "-q"], ["add", "."], [*identity, "commit", "-qm", "Publish"]):
        subprocess.run(["git", *arguments], cwd=root, check=True)
    return Path("reports/published")


@pytest.mark.parametrize("text", [PUBLISHED, "git:HEAD"])
def test_products_that_were_checked_out_are_not_taken_for_a_rerun(checkout, text):
    with pytest.raises(UserError, match="has the products that came with the package"):
        reference(text, checkout)


def test_a_rerun_is_compared_with_what_git_holds(checkout):
    (checkout / "claims.csv").write_text(CLAIMS.replace("E1,in part", "E1,undecided"))
    seal(checkout)
    text = str(compare(checkout, reference(PUBLISHED, checkout)))
    assert "compared with git HEAD (" in text and "changed classes: E1 (in part, here undecided)" in text
    with pytest.raises(UserError, match=r"git nowhere \(no commit\): has no manifest.json"):
        compare(checkout, reference("git:nowhere", checkout))


def test_the_reason_why_git_does_not_read_a_repository_is_said(checkout, monkeypatch):
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")  # as in a container, where root works in a user's clone
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", "/dev/null")
    for text in (PUBLISHED, "git:HEAD"):
        with pytest.raises(NothingToCompareError, match=r"detected dubious ownership .* safe\.directory"):
            reference(text, checkout)


def test_without_git_a_rerun_is_compared_with_the_copy_that_was_kept(tmp_path, monkeypatch):
    folder = make(tmp_path / "unpacked/reports/published")
    monkeypatch.chdir(tmp_path / "unpacked")
    shutil.copytree(folder, KEPT)
    found = compare(Path("reports/published"), reference(PUBLISHED, Path("reports/published")))
    assert found.agrees and f"compared with {KEPT}" in str(found)


@pytest.mark.parametrize(("options", "status"), [([], 1), (["--exit-zero"], 0)])
def test_verify_says_the_same_and_ends_with_a_status(mine, theirs, options, status):
    (mine / "a.csv").write_text("else\n")
    result = CliRunner().invoke(command, [str(mine), "--against", str(theirs), *options])
    assert str(compare(mine, reference(str(theirs), mine))) in result.output
    assert result.exit_code == status
    if status:
        assert isinstance(result.exception, UserError)


def test_nothing_to_compare_with_ends_no_reproduction_in_an_error(tmp_path, monkeypatch):
    make(tmp_path / "unpacked/reports/published")
    monkeypatch.chdir(tmp_path / "unpacked")
    arguments = ["reports/published", "--against", PUBLISHED]
    assert isinstance(CliRunner().invoke(command, arguments).exception, NothingToCompareError)
    result = CliRunner().invoke(command, [*arguments, "--exit-zero"])
    assert result.exit_code == 0 and "neither git's HEAD" in result.output

"""How a run compares with another one: products, verdicts, and what it is never compared with."""

from __future__ import annotations

import base64
import gzip
import json
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from ptl.cli.verify import command
from ptl.errors import UserError
from ptl.files import comparison, manifest
from ptl.files.comparison import GREY_LEVELS, KEPT, PUBLISHED, NothingToCompareError, compare, read_alike, reference

CLAIMS = "id,verdict\nE1,reproduced\nE2,not reproduced\n"


def draw(path: Path, changed: int = 0, size: int = 20) -> Path:
    """A grey ramp; ``changed`` is added to one pixel."""
    pixels = np.tile(np.arange(size, dtype=np.uint8), (20, 1))
    pixels[3, 4] += changed
    Image.fromarray(pixels).save(path)
    return path


def seal(folder: Path, config: dict | None = None) -> None:
    """Write the manifest of what is in a report folder, as the run that made it does."""
    products = [path for path in folder.rglob("*.*") if path.name != manifest.MANIFEST]
    text = json.dumps(manifest.build(products, folder, config or {"run": "tiny", "seeds": 3}, {}))
    (folder / manifest.MANIFEST).write_text(text)
    made = folder.parent.parent / "results" / folder.name / "made.json"
    made.parent.mkdir(parents=True, exist_ok=True)
    made.write_text(text)


def make(folder: Path, claims: str = CLAIMS) -> Path:
    """A small report folder with a manifest."""
    folder.mkdir(parents=True)
    (folder / "claims.csv").write_text(claims)
    (folder / "a.csv").write_text("steps,mean\n8600,0.887123\n")
    (folder / "a.svg").write_text('<path id="m3f2a1b0c9d" d="M 12.345678 7.5 L 3 4"/>')
    draw(folder / "a.png")
    seal(folder)
    return folder


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    return make(tmp_path / "here/reports/published")


@pytest.fixture
def theirs(tmp_path: Path) -> Path:
    return make(tmp_path / "there/reports/published")


def outcome(mine: Path, theirs: Path, name: str) -> str:
    found = compare(mine, reference(str(theirs), mine))
    return next(kind for kind in ("equal", "close", "different", "missing") if name in getattr(found, kind))


def test_equal_runs_agree(mine, theirs):
    found = compare(mine, reference(str(theirs / manifest.MANIFEST), mine))
    assert found.agrees
    text = str(found)
    assert "products: 4 equal, 0 equal within the tolerance, 0 different (of 4)" in text
    assert "verdicts: all 2 equal" in text and "where to look" not in text


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("a.csv", "steps,mean\n8600,0.887124\n", "close"),
        ("a.csv", "steps,mean\n8600,0.887125\n", "different"),
        ("a.csv", "steps,mean\n8601,0.887123\n", "different"),
        ("a.csv", "steps,Mean\n8600,0.887123\n", "different"),
        ("a.csv", "steps,mean\n8600,0.887123\n1,2\n", "different"),
        ("a.svg", '<path id="mffffffffff" d="M 12.345679 7.5 L 3 4"/>', "close"),
        ("a.svg", '<path id="m3f2a1b0c9d" d="M 12.345678 7.5 L 3 5"/>', "different"),
    ],
)
def test_only_the_last_digit_of_fractions_may_differ(mine, theirs, name, content, expected):
    (mine / name).write_text(content)
    assert outcome(mine, theirs, name) == expected


def test_no_text_is_within_the_tolerance_that_cannot_be_read():
    assert not read_alike(b"\xff\xfe", b"\xff\xfd")
    assert not read_alike(b"a 1.5", b"a \xff")


def test_packed_data_are_compared_unpacked():
    def page(level: int, value: str) -> bytes:
        data = json.dumps({"values": [value] * 50}).encode()
        return b'<script id="data">' + base64.b64encode(gzip.compress(data, level, mtime=0)) + b"</script>"

    assert page(1, "0.5") != page(9, "0.5")
    assert read_alike(page(1, "0.5"), page(9, "0.5"))
    assert not read_alike(page(1, "0.5"), page(9, "0.7"))


PACKED = gzip.compress(bytes(range(256)), mtime=0)


@pytest.mark.parametrize("damaged", [PACKED[:10] + b"\xff" + PACKED[11:], PACKED[:-40]], ids=["wrong", "short"])
def test_damaged_packed_data_are_within_no_tolerance(damaged):
    page = base64.b64encode(damaged)
    assert not read_alike(page + b" 0.5", page + b" 0.6")


def test_packed_data_are_unpacked_up_to_a_limit(monkeypatch):
    page = base64.b64encode(gzip.compress(bytes(10**5)))
    assert read_alike(page + b" 0.5", page + b" 0.6")
    monkeypatch.setattr(comparison, "MOST_BYTES", 10**5 - 1)
    assert not read_alike(page + b" 0.5", page + b" 0.6")


@pytest.mark.parametrize("number", [b"0.1e-999999999", b"1.5e999999999", b"0.1e-" + b"9" * 30])
def test_numbers_beyond_all_range_are_within_no_tolerance(number):
    assert not read_alike(number, b"0.5")


@pytest.mark.parametrize("side", [10**5, 13_000])
def test_pictures_too_large_to_look_at_differ_without_a_warning(mine, theirs, side, recwarn):
    def chunk(name: bytes, content: bytes) -> bytes:
        return len(content).to_bytes(4, "big") + name + content + zlib.crc32(name + content).to_bytes(4, "big")

    header = side.to_bytes(4, "big") * 2 + bytes([8, 0, 0, 0, 0])
    (mine / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")))
    assert outcome(mine, theirs, "a.png") == "different"
    assert not recwarn.list


def test_claims_that_cannot_be_read_have_no_verdicts(mine, theirs):
    (mine / "claims.csv").write_text(f"id,verdict\nE1,{'x' * 200_000}\n")
    found = compare(mine, reference(str(theirs), mine))
    assert found.different == ["claims.csv"]
    assert found.verdicts == {"E1": ("reproduced", "-"), "E2": ("not reproduced", "-")}


def test_names_of_claims_are_printed_without_control_characters(mine, theirs):
    (mine / "claims.csv").write_text("id,verdict\nE\x1b[31m,reproduced\n")
    assert r"E\x1b[31m (-, here reproduced)" in str(compare(mine, reference(str(theirs), mine)))


def test_a_reference_that_is_no_ordinary_file_is_never_waited_for(mine, theirs):
    (mine / "a.csv").write_text("else\n")
    for other in ("/proc/self/status", "/dev/zero"):  # of the system's: without an end or a size
        (theirs / "a.csv").unlink()
        (theirs / "a.csv").symlink_to(other)
        assert not reference(str(theirs), mine).read("a.csv")
        assert outcome(mine, theirs, "a.csv") == "different"


@pytest.mark.parametrize(("levels", "expected"), [(GREY_LEVELS, "close"), (GREY_LEVELS + 1, "different")])
def test_pixels_may_differ_by_a_few_levels(mine, theirs, levels, expected):
    draw(mine / "a.png", changed=levels)
    (mine / "a.csv").unlink()
    assert outcome(mine, theirs, "a.png") == expected


def test_a_picture_with_equal_numbers_and_an_equal_vector_twin_is_within_the_tolerance(mine, theirs):
    draw(mine / "a.png", changed=100)
    assert outcome(mine, theirs, "a.png") == "close"
    (mine / "a.csv").write_text("steps,mean\n1,2\n")
    assert outcome(mine, theirs, "a.png") == "different"


@pytest.mark.parametrize("broken", ["damaged", "size"])
def test_a_damaged_picture_or_one_of_another_size_differs_whatever_its_twins_are(mine, theirs, broken):
    if broken == "size":
        draw(mine / "a.png", size=21)
    else:
        (mine / "a.png").write_bytes(b"\x89PNG")
    assert outcome(mine, theirs, "a.png") == "different"


def test_verdicts_settings_and_missing_products_are_named(tmp_path, theirs):
    mine = make(tmp_path / "x/reports/published", CLAIMS.replace("not reproduced", "partly reproduced"))
    seal(mine, {"run": "tiny", "seeds": 10})
    (mine / "a.svg").unlink()
    found = compare(mine, reference(str(theirs), mine))
    assert not found.agrees
    text = str(found)
    assert "missing: a.svg" in text
    assert "verdicts: 1 of 2 equal" in text and "changed: E2 (not reproduced, here partly reproduced)" in text
    assert "configuration: seeds (3, here 10)" in text and "where to look: 'git diff" in text


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


def test_products_that_were_checked_out_are_not_taken_for_a_rerun(checkout):
    for text in (PUBLISHED, "git:HEAD"):
        with pytest.raises(UserError, match="holds products that came with the package"):
            reference(text, checkout)


def test_a_rerun_is_compared_with_what_git_holds(checkout):
    (checkout / "claims.csv").write_text(CLAIMS.replace("E1,reproduced", "E1,undecided"))
    seal(checkout)
    found = compare(checkout, reference(PUBLISHED, checkout))
    assert found.other.startswith("git HEAD (")
    assert found.verdicts == {"E1": ("reproduced", "undecided")}
    assert found.different == ["claims.csv"] and len(found.equal) == 3
    with pytest.raises(UserError, match="git nowhere holds no manifest"):
        compare(checkout, reference("git:nowhere", checkout))


def test_without_git_a_rerun_is_compared_with_the_copy_that_was_kept(tmp_path, monkeypatch):
    folder = make(tmp_path / "unpacked/reports/published")
    monkeypatch.chdir(tmp_path / "unpacked")
    shutil.copytree(folder, KEPT)
    found = compare(Path("reports/published"), reference(PUBLISHED, Path("reports/published")))
    assert found.agrees and found.other.startswith(KEPT)


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

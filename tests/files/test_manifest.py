"""The manifest: any damage to a report folder is found, and two runs are compared."""

from __future__ import annotations

import json
import random
from pathlib import Path

import numpy as np
import pytest
from damage import SEED, damages
from PIL import Image

from ptl.errors import UserError
from ptl.files import manifest
from ptl.files.verification import faults_of


def draw(path: Path, changed: int = 0, size: int = 20) -> Path:
    """A grey ramp; ``changed`` is added to one pixel."""
    pixels = np.tile(np.arange(size, dtype=np.uint8), (20, 1))
    pixels[3, 4] += changed
    Image.fromarray(pixels).save(path)
    return path


def report(folder: Path) -> Path:
    """A report folder with a manifest; return the manifest."""
    folder.mkdir(parents=True)
    chance = random.Random(SEED)
    products = [folder / name for name in ("a.csv", "b.html", "c.svg")]
    for path in products:
        path.write_bytes(chance.randbytes(2000))
    products.append(draw(folder / "figure.png"))
    path = folder / manifest.MANIFEST
    path.write_text(json.dumps(manifest.build(products, folder, {"run": "tiny"}), indent=1, sort_keys=True) + "\n")
    return path


def test_every_damage_to_a_report_folder_is_found(tmp_path, record_property):
    own = report(tmp_path / "reports/tiny")
    assert faults_of(own) == []
    tried = 0
    for path in sorted(own.parent.iterdir()):
        whole = path.read_bytes()
        for kind, damaged in damages(whole, random.Random(SEED)):
            if damaged.strip() != whole.strip():
                tried += 1
                path.write_bytes(damaged)
                assert faults_of(own), f"{path.name}: {kind}"
        path.unlink()
        assert faults_of(own)
        path.write_bytes(whole)
    record_property("damages tried, all found: report folder with manifest", tried)


@pytest.fixture
def runs(tmp_path) -> tuple[Path, Path]:
    """A report folder, and the manifest of an equal run."""
    return report(tmp_path / "mine").parent, report(tmp_path / "theirs")


def test_equal_runs_do_not_differ(runs):
    assert manifest.differences(*runs) == []


@pytest.mark.parametrize("name", ["a.csv", "b.html", "c.svg"])
def test_one_byte_makes_a_difference(runs, name):
    folder, other = runs
    path = folder / name
    path.write_bytes(path.read_bytes()[:-1] + b"\0")
    assert manifest.differences(folder, other) == [f"{path}: differs from {other}"]


def test_a_missing_product_is_named_with_the_command_that_makes_it(runs):
    folder, other = runs
    (folder / "a.csv").unlink()
    [line] = manifest.differences(folder, other)
    assert line == f"{folder}/a.csv: is missing; run 'snakemake {folder}/a.csv --cores 1' to make it"


@pytest.mark.parametrize(
    ("levels", "equal"), [(1, True), (manifest.GREY_LEVELS, True), (manifest.GREY_LEVELS + 1, False)]
)
def test_pixels_may_differ_by_a_few_levels(runs, levels, equal):
    folder, other = runs
    draw(folder / "figure.png", changed=levels)
    assert (manifest.differences(folder, other) == []) == equal


def test_pictures_of_another_size_or_damaged_differ(runs):
    folder, other = runs
    draw(folder / "figure.png", size=21)
    assert len(manifest.differences(folder, other)) == 1
    (folder / "figure.png").write_bytes(b"\x89PNG")
    assert len(manifest.differences(folder, other)) == 1


def test_without_the_other_picture_only_its_checksum_counts(runs):
    folder, other = runs
    (other.parent / "figure.png").unlink()
    assert manifest.differences(folder, other) == []
    draw(folder / "figure.png", changed=1)
    assert len(manifest.differences(folder, other)) == 1


def test_other_files_are_no_manifests(tmp_path):
    path = tmp_path / manifest.MANIFEST
    path.write_text("[]")
    with pytest.raises(UserError, match="is not a manifest"):
        manifest.differences(tmp_path, path)

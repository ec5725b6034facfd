"""The manifest: any damage to a report folder is found."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest
from damage import SEED, damages

from ptl.errors import UserError
from ptl.files import manifest
from ptl.files.verification import faults_of


def report(folder: Path) -> Path:
    """A report folder with a manifest; return the manifest."""
    folder.mkdir(parents=True)
    chance = random.Random(SEED)
    products = [folder / name for name in ("a.csv", "b.html", "c.svg")]
    for path in products:
        path.write_bytes(chance.randbytes(2000))
    path = folder / manifest.MANIFEST
    path.write_text(json.dumps(manifest.build(products, folder, {"run": "tiny"}, {}), indent=1, sort_keys=True) + "\n")
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


@pytest.mark.parametrize("maps", [["rooms"], 1, None, {"rooms": 1}])
def test_maps_are_names_and_digests(maps, tmp_path):
    path = report(tmp_path / "reports/tiny")
    found = {**json.loads(path.read_text()), "maps": maps}
    path.write_text(json.dumps({**found, "content": manifest._content(found)}))
    with pytest.raises(UserError, match=r"is not a manifest .*map"):
        manifest.read(path)


def test_a_product_with_a_blank_name_is_shown_as_such(tmp_path):
    path = report(tmp_path / "reports/tiny")
    path.write_text(json.dumps({**json.loads(path.read_text()), "products": {" ": "-"}}))
    with pytest.raises(UserError, match="' ' has no sha256"):
        manifest.read(path)


def test_other_files_are_no_manifests(tmp_path):
    path = tmp_path / manifest.MANIFEST
    path.write_text("[]")
    with pytest.raises(UserError, match="is not a manifest"):
        manifest.read(path)

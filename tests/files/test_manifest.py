"""The manifest: any damage to a product of a report folder is found."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

import pytest
from damage import SEED, damages

from ptl.errors import UserError
from ptl.files import manifest


def report(folder: Path) -> Path:
    """A report folder with a manifest; return the manifest."""
    folder.mkdir(parents=True)
    chance = random.Random(SEED)
    products = [folder / name for name in ("a.csv", "b.html", "c.svg")]
    for path in products:
        path.write_bytes(chance.randbytes(2000))
    path = folder / manifest.MANIFEST
    path.write_text(manifest.to_json(manifest.build(products, folder, {"run": "tiny"}, {})))
    return path


def test_files_beside_products_that_it_does_not_name_are_strangers(tmp_path):
    product, other = tmp_path / "figures/map.png", tmp_path / "figures/map_of_old.png"
    product.parent.mkdir()
    for path in (product, other, tmp_path / "report.html"):
        path.write_bytes(b"made")
    built = manifest.build([product, tmp_path / "report.html"], tmp_path, {"run": "tiny"}, {})
    (tmp_path / manifest.MANIFEST).write_text(manifest.to_json(built))
    (tmp_path / "benchmark.md").write_text("not of the run")
    assert manifest.strangers(tmp_path) == [other]
    shutil.rmtree(product.parent)
    assert manifest.strangers(tmp_path) == []


def test_every_damage_to_a_product_is_found(tmp_path, record_property):
    folder = report(tmp_path / "reports/tiny").parent
    assert manifest.damages(folder) == []
    tried = 0
    for path in sorted(folder.glob("?.*")):
        whole = path.read_bytes()
        for kind, damaged in damages(whole, random.Random(SEED)):
            if damaged != whole:
                tried += 1
                path.write_bytes(damaged)
                [fault] = manifest.damages(folder)
                assert fault.startswith(f"{path}: differs from manifest.json; "), kind
        path.unlink()
        [fault] = manifest.damages(folder)
        assert "No such file" in fault
        path.write_bytes(whole)
    record_property("damages tried, all found", tried)


@pytest.mark.parametrize(
    "content", ["", "[]", '{"config": {}}', '{"config":{},"maps":{},"versions":{},"products":{"../a":"x"}}']
)
def test_other_files_are_no_manifests(tmp_path, content):
    path = tmp_path / manifest.MANIFEST
    path.write_text(content)
    with pytest.raises(UserError, match=f"^{path}: (is not a manifest|names)"):
        manifest.read(path)
    assert manifest.products_in(tmp_path) == {}

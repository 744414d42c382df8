"""`make batch` without a local copy: models of Thingi10K through the package, here with a stand-in for the data set.

The stand-in has what is used of the package's interface (version 1.5): init(variant), then dataset(file_id) with one
row for each model, which names file_id and file_path, and RuntimeError where it was not initialised or not fetched.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from neurframe_cli.batch.inputs import find_models
from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import StageError, UsageError

ROOT = Path(__file__).parent.parent
PACKAGE = """
from pathlib import Path

FILES = Path(__file__).parent / "raw"
ready = False


def init(variant=None):
    global ready
    if not FILES.is_dir():
        raise RuntimeError("Failed to initialize dataset: no route to host")
    ready = variant == "raw"


def dataset(file_id=None):
    if not ready:
        raise RuntimeError("Dataset is not initialized. Call init() first.")
    for path in sorted(FILES.iterdir()):
        if int(path.stem) in file_id:
            yield {"file_id": int(path.stem), "file_path": str(path), "license": "Public Domain"}
"""


@pytest.fixture
def data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder with the files of the stand-in, which `import thingi10k` finds."""
    package = tmp_path / "packages" / "thingi10k"
    (package / "raw").mkdir(parents=True)
    (package / "__init__.py").write_text(PACKAGE)
    shutil.copy(ROOT / "samples" / "cube.stl", package / "raw" / "36088.stl")
    (package / "raw" / "37621.obj").write_text("this is no mesh\n")
    monkeypatch.syspath_prepend(str(package.parent))
    monkeypatch.delitem(sys.modules, "thingi10k", raising=False)
    yield package / "raw"
    sys.modules.pop("thingi10k", None)


def test_the_package_names_the_files(data_set: Path, tmp_path: Path) -> None:
    models = tmp_path / "models.txt"
    models.write_text("# two models\nthingi10k:37621\nthingi10k:36088\n")
    assert find_models([str(models)]) == [data_set / "36088.stl", data_set / "37621.obj"]


def test_a_model_that_the_data_set_lacks_is_named(data_set: Path) -> None:
    with pytest.raises(UsageError, match="no model 7, 8"):
        find_models(["thingi10k:8", "thingi10k:36088", "thingi10k:7"])


def test_a_data_set_that_cannot_be_fetched_is_an_error_with_a_way_out(data_set: Path) -> None:
    shutil.rmtree(data_set)
    with pytest.raises(StageError, match="no route to host") as failed:
        find_models(["thingi10k:36088"])
    assert "--thingi10k" in str(failed.value.hint)


def test_without_the_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "thingi10k", None)
    with pytest.raises(UsageError, match="extra `thingi10k`"):
        find_models(["thingi10k:36088"])


def test_a_batch_runs_on_what_the_package_gives(data_set: Path, tmp_path: Path) -> None:
    models, output = tmp_path / "models.txt", tmp_path / "batch"
    models.write_text("thingi10k:37621\n")
    run_command_line(["batch", str(models), "-o", str(output), "--jobs", "1", "-q"])
    (line,) = (output / "results.jsonl").read_text().splitlines()
    outcome = json.loads(line)
    assert outcome["model"] == str(data_set / "37621.obj")
    assert outcome["outcome"] == "unusable"


def test_make_batch_installs_the_extra_and_runs_the_list(tmp_path: Path) -> None:
    command = ["make", "-n", "batch", f"VENV={tmp_path}/venv", f"BATCH_OUTPUT={tmp_path}/out"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "tests/requirements.py thingi10k" in said
    (run,) = (line for line in said.splitlines() if "neurframe batch" in line)
    assert f"batch benchmarks/thingi10k.txt -o {tmp_path}/out" in run
    assert "--thingi10k" not in run
    copy = subprocess.run(
        [*command, f"THINGI10K={tmp_path}"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "tests/requirements.py thingi10k" not in copy.stdout
    assert f'--thingi10k "{tmp_path}"' in copy.stdout

"""Other homes, locales, names, streams and drivers: the same bytes, or a warning, and never an error."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from faults import CUBE, assert_clear, assert_same, clean_environment, command, copy_of, neurframe, words

from neurframe_cli.errors import UsageError
from neurframe_cli.pipeline.atomic import sha256_of
from neurframe_cli.pipeline.manifest import read_manifest

OPTIONS = ["--hex", "--scale", "5", "--method", "discrete", "--no-pictures", "--threads", "1"]
RESULTS = ("tets.mesh", "field.safetensors", "tets.fra", "cross.npz", "map.hexex", "hex.vtk")


def has_locale(name: str) -> bool:
    listed = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=False).stdout
    return name.lower().replace("-", "") in listed.lower().replace("-", "").split()


def whole_run(model: Path, folder: Path, environment: dict[str, str] | None = None) -> dict[str, str]:
    """`neurframe run` in a folder; hashes of what it made."""
    ended = neurframe("run", str(model), "-w", "out.neurframe", *OPTIONS, cwd=folder, env=environment)
    assert ended.code == 0, ended.said
    assert "Traceback" not in ended.said
    return {name: sha256_of(folder / "out.neurframe" / name) for name in RESULTS}


@pytest.fixture(scope="module")
def usual(staged: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """A tet mesh as the model, and what a run in usual surroundings makes of it."""
    folder = tmp_path_factory.mktemp("usual")
    shutil.copyfile(staged["done"] / "tets.mesh", folder / "model.mesh")
    return folder / "model.mesh", whole_run(folder / "model.mesh", folder)


def no_home(folder: Path) -> dict[str, str]:
    environment = clean_environment(LC_ALL="C", CUDA_VISIBLE_DEVICES="")
    return {
        name: value for name, value in environment.items() if name not in ("HOME", "TERM", "LANG", "USER")
    }


def missing_home(folder: Path) -> dict[str, str]:
    return clean_environment(HOME="/nonexistent/home", PYTHONIOENCODING="ascii", TERM="dumb")


def german(folder: Path) -> dict[str, str]:
    """Where a comma stands before the decimals."""
    if not has_locale("de_DE.utf8"):
        pytest.skip("the locale de_DE.UTF-8 is not installed")
    return clean_environment(LC_ALL="de_DE.UTF-8")


@pytest.mark.slow
@pytest.mark.parametrize("environment", [no_home, missing_home, german])
def test_whole_run_in_another_environment(
    environment: Callable[[Path], dict[str, str]], usual: tuple[Path, dict[str, str]], tmp_path: Path
) -> None:
    model, expected = usual
    assert whole_run(model, tmp_path, environment(tmp_path)) == expected


@pytest.mark.slow
def test_whole_run_with_unusual_names(tmp_path: Path) -> None:
    """Letters of several alphabets, spaces and quotes in the model, the folders, the further file and TMPDIR."""
    folder = tmp_path / "Ordner mit 'Räumen' und 日本語"
    (folder / "tmp — ü").mkdir(parents=True)
    model = folder / "Teil №1 größe.stl"
    shutil.copyfile(CUBE, model)
    arguments = [
        "run",
        model.name,
        *OPTIONS,
        "--tet-edge-length",
        "0.3",
        "--epsilon",
        "0.01",
        "-o",
        "Ergebnis ö.vtu",
    ]
    environment = clean_environment(TMPDIR=str(folder / "tmp — ü"))
    ended = neurframe(*arguments, cwd=folder, env=environment)
    assert ended.code == 0, ended.said
    assert (folder / "Ergebnis ö.vtu").stat().st_size > 0
    assert (folder / "Teil №1 größe.neurframe" / "report.html").exists()
    again = neurframe(*arguments, cwd=folder, env=environment | {"LC_ALL": "C", "PYTHONIOENCODING": "ascii"})
    assert again.code == 0, again.said
    assert "unchanged, skipped" in again.said


def close_streams() -> None:
    os.closerange(0, 3)


def test_a_stage_without_standard_streams(staged: dict[str, Path], tmp_path: Path) -> None:
    """What is printed must not get into a file that was opened in place of a stream."""
    workspace = copy_of(staged["hex"], tmp_path)
    child = subprocess.Popen(
        command(*words("hex", workspace)), env=clean_environment(), preexec_fn=close_streams
    )
    assert child.wait() == 0
    assert_same("hex", workspace, staged["done"])


@pytest.mark.slow
def test_a_machine_without_opengl_has_no_pictures_and_all_the_rest(
    staged: dict[str, Path], tmp_path: Path
) -> None:
    workspace = copy_of(staged["discretize"], tmp_path)
    environment = clean_environment(
        VTK_DEFAULT_OPENGL_WINDOW="vtkXOpenGLRenderWindow", DISPLAY=":no-such-display"
    )
    drawing = [word for word in words("discretize", workspace) if word != "--no-pictures"]
    ended = neurframe(*drawing, env=environment)
    assert ended.code == 0
    assert "warning: no pictures" in ended.said
    assert_same("discretize", workspace, staged["done"])
    assert not list(workspace.glob("*.png"))
    assert any("no OpenGL" in warning for warning in read_manifest(workspace).stages["discretize"].warnings)


def test_a_gpu_that_is_not_there(staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged["train"], tmp_path)
    environment = clean_environment(CUDA_VISIBLE_DEVICES="")
    ended = neurframe(*words("train", workspace), "--device", "cuda", env=environment)
    assert_clear(ended, UsageError.exit_code)
    assert "cuda" in ended.said.lower()
    assert neurframe(*words("train", workspace), env=environment).code == 0


def test_a_name_that_is_no_unicode(staged: dict[str, Path], tmp_path: Path) -> None:
    """Bytes that no encoding gives a meaning to, in a folder from another machine."""
    workspace = tmp_path / os.fsdecode(b"w\xff.neurframe")
    try:
        shutil.copytree(staged["done"], workspace)
    except OSError:
        pytest.skip("this file system takes Unicode names only")
    log = tmp_path / "log.jsonl"
    # in processes of their own: a captured name that is no Unicode is more than pytest's workers can report
    assert neurframe("report", "-w", str(workspace), "--log-json", str(log)).code == 0
    assert neurframe(*words("hex", workspace), "--force").code == 0
    assert_same("hex", workspace, staged["done"])
    assert neurframe("train", "-w", f"{workspace}-missing").code == UsageError.exit_code

"""Files from strangers: nothing in them is run, nothing is written outside the workspace, nothing fills the memory."""

from __future__ import annotations

import ast
import json
import os
import pickle
import shutil
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from faults import CUBE, OUTPUTS, STAGES, assert_clear, clean_environment, copy_of, neurframe, words

import neurframe_cli
from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import StageError, UnreadableFile, UsageError
from neurframe_cli.field.field_file import read_field
from neurframe_cli.mesh.arrays import silent
from neurframe_cli.mesh.read_points import read_points
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.pipeline.native import Limits, run_program
from neurframe_cli.pipeline.quad_source import read_crosses
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.process import run_child
from neurframe_cli.process.memory import high_water_mib

PACKAGE = Path(neurframe_cli.__file__).parent
# what runs code that is in a file or in a string
FORBIDDEN_CALLS = {
    "eval",
    "exec",
    "compile",
    "__import__",
    "os.system",
    "os.popen",
    "torch.load",
    "yaml.load",
}
FORBIDDEN_MODULES = {"pickle", "cPickle", "dill", "joblib", "shelve", "marshal", "cloudpickle"}


def trees() -> Iterator[tuple[Path, ast.AST]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        yield path, ast.parse(path.read_text(encoding="utf-8"))


def test_no_code_comes_from_files_and_no_shell_is_asked() -> None:
    found = []
    for path, tree in trees():
        for node in ast.walk(tree):
            where = f"{path.name}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = (
                    [node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
                )
                found += [f"{where} {name}" for name in names if name.split(".")[0] in FORBIDDEN_MODULES]
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                options = {word.arg: ast.unparse(word.value) for word in node.keywords}
                if called in FORBIDDEN_CALLS or options.get("shell", "False") != "False":
                    found.append(f"{where} {called}")
                if called in ("np.load", "numpy.load") and options.get("allow_pickle") != "False":
                    found.append(f"{where} {called}")
    assert found == []


def test_children_are_started_in_one_place_only() -> None:
    """There they get an explicit list of arguments, a clean environment and limits."""
    starters = {
        path.relative_to(PACKAGE).as_posix()
        for path, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Import) and any(a.name == "subprocess" for a in node.names)
    }
    assert starters == {"process/run_child.py"}


class Bomb:
    """Leaves a file where it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[object, tuple[str, int]]:
        return os.mkdir, (str(self.trace), 0o700)


def test_a_pickle_in_any_artifact_is_not_unpickled(tmp_path: Path) -> None:
    trace = tmp_path / "pwned"
    bomb = np.array([Bomb(trace)], dtype=object)
    np.save(tmp_path / "points.npy", bomb, allow_pickle=True)
    np.savez(tmp_path / "cross.npz", V=bomb, F=bomb, crosses=bomb)
    (tmp_path / "field.safetensors").write_bytes(pickle.dumps(Bomb(trace)))
    with pytest.raises(UnreadableFile):
        read_points(tmp_path / "points.npy")
    with pytest.raises(UnreadableFile):
        read_crosses(tmp_path / "cross.npz")
    with pytest.raises(UnreadableFile):
        read_field(tmp_path / "field.safetensors")
    assert not trace.exists()
    pickle.loads(pickle.dumps(Bomb(trace)))
    assert trace.exists(), "the bomb would have worked"


def test_children_do_not_see_what_is_exported_here(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("SECRET_TOKEN", "LD_PRELOAD_X", "PYTHONSTARTUP", "PYTHONINSPECT", "BASH_ENV"):
        monkeypatch.setenv(name, "x")
    shown = (
        run_child([sys.executable, "-c", "import os; print(*os.environ)"], name="child")
        .stdout.decode()
        .split()
    )
    assert not {"SECRET_TOKEN", "LD_PRELOAD_X", "PYTHONSTARTUP", "PYTHONINSPECT", "BASH_ENV"} & set(shown)


def test_words_of_a_shell_in_a_name_are_a_name(tmp_path: Path) -> None:
    model = tmp_path / "$(touch pwned);`touch pwned` & 'quote\".stl"
    shutil.copyfile(CUBE, model)
    ended = neurframe("tetize", str(model), "--edge-length", "0.3", "-q", cwd=tmp_path)
    assert ended.code == 0, ended.said
    assert not (tmp_path / "pwned").exists()
    assert (tmp_path / f"{model.stem}.neurframe" / "tets.mesh").exists()


def test_a_folder_that_is_called_like_an_option(staged: dict[str, Path], tmp_path: Path) -> None:
    shutil.copytree(staged["hex"], tmp_path / "-o")
    ended = neurframe(*words("hex", Path("-o")), cwd=tmp_path)
    assert ended.code == 0, ended.said
    assert (tmp_path / "-o" / "hex.vtk").exists()


def test_a_module_in_the_folder_of_a_program_is_not_run(staged: dict[str, Path], tmp_path: Path) -> None:
    """fTetWild runs in a folder of the workspace."""
    workspace = copy_of(staged["tetize"], tmp_path)
    (workspace / "numpy.py").write_text("raise SystemExit('pwned')\n")
    ended = neurframe(*words("tetize", workspace), env=clean_environment(TMPDIR=str(workspace)))
    assert ended.code == 0, ended.said


@pytest.mark.parametrize("stage", STAGES)
def test_a_link_in_place_of_an_artifact_writes_nothing_elsewhere(
    stage: str, staged: dict[str, Path], tmp_path: Path
) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    victims = []
    for number, name in enumerate(OUTPUTS[stage]):
        victims.append(tmp_path / f"victim-{number}")
        victims[-1].write_text("precious")
        (workspace / name).symlink_to(victims[-1])
    code = run_command_line(words(stage, workspace))
    assert code in (UsageError.exit_code, StageError.exit_code)
    assert [victim.read_text() for victim in victims] == ["precious"] * len(victims)


@pytest.mark.parametrize("name", ["manifest.json", "train.checkpoint", "train.jsonl", "report.html", ".lock"])
def test_a_link_in_place_of_any_other_file(name: str, staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged["train"], tmp_path)
    victim = tmp_path / "victim"
    victim.write_text('{"format": "neurframe-workspace", "version": 1, "stages": {}}')
    before = victim.read_bytes()
    (workspace / name).unlink(missing_ok=True)
    (workspace / name).symlink_to(victim)
    run_command_line(["report", "-w", str(workspace), "-q"])
    run_command_line(words("train", workspace))
    assert victim.read_bytes() == before


@pytest.mark.parametrize("name", ["../victim", "/etc/hostname", "sub/../../victim"])
def test_a_manifest_cannot_name_files_outside(
    name: str, staged: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    workspace = copy_of(staged["done"], tmp_path)
    (tmp_path / "victim").write_text("precious")
    document = json.loads((workspace / "manifest.json").read_text())
    for record in document["stages"].values():
        record["outputs"][name] = "0" * 64
        record["inputs"][name] = "0" * 64
    (workspace / "manifest.json").write_text(json.dumps(document))
    for command in (words("hex", workspace), ["report", "-w", str(workspace), "-q"]):
        code = run_command_line(command)
        said = capsys.readouterr().err
        assert code in (0, UsageError.exit_code)
        assert "Traceback" not in said
        assert "internal error" not in said
        if (workspace / "report.html").exists():
            assert "precious" not in (workspace / "report.html").read_text(encoding="utf-8")
    assert (tmp_path / "victim").read_text() == "precious"


def test_an_artifact_is_always_inside(tmp_path: Path) -> None:
    for name in ("../x", "/x", "a/../../x"):
        with pytest.raises(UsageError, match="outside the workspace"):
            Workspace(tmp_path) / name


def test_a_workspace_does_not_say_which_programs_run(staged: dict[str, Path], tmp_path: Path) -> None:
    """Its neurframe.toml sets options; programs are named by the user's own files only."""
    workspace = copy_of(staged["hex"], tmp_path)
    program = workspace / "evil.sh"
    program.write_text(f"#!/bin/sh\ntouch {tmp_path}/pwned\nexit 3\n")
    program.chmod(0o755)
    config = workspace / "neurframe.toml"
    config.write_text('[executables]\ncubecover = "./evil.sh"\n')
    for ended in (neurframe(*words("hex", workspace)), neurframe("hex", "-q", cwd=workspace)):
        assert_clear(ended, UsageError.exit_code)
        assert "names programs to run" in ended.said
    assert not (tmp_path / "pwned").exists()
    assert neurframe(*words("hex", workspace), "--config", str(config)).code == StageError.exit_code
    assert (tmp_path / "pwned").exists(), "who names the file, trusts it"


def sparse(path: Path, size: int) -> None:
    """A file of that size that takes no room."""
    with path.open("wb") as file:
        file.truncate(size)


@pytest.mark.parametrize(
    ("name", "stage"),
    [
        ("tets.mesh", "train"),
        ("features.json", "train"),
        ("manifest.json", "train"),
        ("neurframe.toml", "train"),
        ("field.safetensors", "discretize"),
        ("surface.ply", "discretize"),
        ("cross.npz", "quad"),
        ("tets.fra", "hex"),
    ],
)
def test_a_file_of_any_size_is_not_read_into_memory(
    name: str, stage: str, staged: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    sparse(workspace / name, 3 << 30)
    before = high_water_mib()
    assert run_command_line(words(stage, workspace)) == UnreadableFile.exit_code
    assert f"{name}: 3072 MiB, at most" in capsys.readouterr().err
    assert high_water_mib() - before < 500


def test_a_pipe_in_place_of_a_file_does_not_hang(tmp_path: Path, staged: dict[str, Path]) -> None:
    workspace = copy_of(staged["train"], tmp_path)
    for name in ("tets.mesh", "manifest.json"):
        (workspace / name).unlink()
        os.mkfifo(workspace / name)
        assert run_command_line(words("train", workspace)) == UsageError.exit_code


def test_archives_that_unpack_to_far_more(tmp_path: Path) -> None:
    zeros = np.zeros((2_000_000, 3))
    np.savez_compressed(tmp_path / "cross.npz", V=zeros, F=zeros.astype(np.int64), crosses=zeros)
    with pytest.raises(UnreadableFile, match="unpacks from"):
        read_crosses(tmp_path / "cross.npz")
    model = tmp_path / "part.3mf"
    with zipfile.ZipFile(model, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", b" " * (50 << 20))
    with pytest.raises(UnreadableFile, match="unpacks from"):
        read_surface(model)


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
LAUGHTER = (
    f'<?xml version="1.0"?><!--{" " * 100_000}-->'
    f'<!DOCTYPE m [<!ENTITY l0 "{"ha" * 50}">{LAUGHS}]><model>&l9;</model>'
)


def test_xml_that_grows_when_it_is_read(tmp_path: Path) -> None:
    """Entities that are made of entities, behind a long comment: 5 GB of laughter."""
    before = high_water_mib()
    (tmp_path / "part.vtu").write_text(LAUGHTER.replace("model", "VTKFile"))
    with zipfile.ZipFile(tmp_path / "part.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", LAUGHTER)
    for name in ("part.vtu", "part.3mf"):
        with pytest.raises(UnreadableFile):
            read_surface(tmp_path / name)
    assert high_water_mib() - before < 300


def test_an_array_that_claims_to_be_huge(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", np.zeros((4, 3)))
    content = (tmp_path / "points.npy").read_bytes()
    (tmp_path / "points.npy").write_bytes(
        content.replace(b"(4, 3), }            ", b"(9000000000000, 3), }", 1)
    )
    assert b"9000000000000" in (tmp_path / "points.npy").read_bytes()
    with pytest.raises(UnreadableFile):
        read_points(tmp_path / "points.npy")


def test_a_program_that_prints_without_end_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chatty = tmp_path / "chatty.sh"
    chatty.write_text("#!/bin/sh\nexec yes\n")
    chatty.chmod(0o755)
    monkeypatch.setenv("NEURFRAME_QEX", str(chatty))
    with pytest.raises(StageError, match="64 MiB"):
        run_program("qex", [], Limits(), silent)


def test_names_are_text_in_the_report(staged: dict[str, Path], tmp_path: Path) -> None:
    hostile = "<img src=x onerror=alert(1)>"
    workspace = tmp_path / f"{hostile}.neurframe"
    shutil.copytree(staged["done"], workspace)
    document = json.loads((workspace / "manifest.json").read_text())
    document["stages"]["hex"] |= {"status": "failed", "error": hostile, "warnings": [hostile]}
    document["stages"]["tetize"]["options"][hostile] = hostile
    (workspace / "manifest.json").write_text(json.dumps(document))
    assert run_command_line(["report", "-w", str(workspace), "-q"]) == 0
    page = (workspace / "report.html").read_text(encoding="utf-8")
    assert hostile not in page
    assert "&lt;img src=x onerror=alert(1)&gt;" in page

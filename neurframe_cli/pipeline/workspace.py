"""The workspace: a folder that holds every artifact of one model, found by the rules that all commands share."""

from __future__ import annotations

import contextlib
from pathlib import Path

from neurframe_cli.errors import NeurframeError, UsageError
from neurframe_cli.mesh.open_file import check_file
from neurframe_cli.pipeline.atomic import write_error
from neurframe_cli.pipeline.manifest import MANIFEST_NAME, Manifest, read_manifest

SUFFIX = ".neurframe"


class Workspace:
    """The artifacts of one model.  `workspace / "tets.mesh"` is the path of an artifact, always inside the folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __truediv__(self, name: str) -> Path:
        """Path of artifact `name`; a link that leads out of the folder is refused."""
        path = self.folder / name
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise UsageError(f"{path} lies outside the workspace {self.folder}")
        return path

    def require(self, name: str, made_by: str) -> Path:
        """Path of an artifact that must exist; raises UsageError naming the command that makes it."""
        path = self / name
        if not path.is_file():
            raise UsageError(f"{path} is missing", hint=f"run `neurframe {made_by} -w {self.folder}` first")
        return path


def workspace_folder(model: Path, chosen: Path | None) -> Path:
    """The folder of a command with an INPUT: the one chosen with -w, else STEM.neurframe here."""
    return chosen if chosen is not None else Path(model.stem + SUFFIX)


def workspace_for_input(model: Path, chosen: Path | None) -> Workspace:
    """The workspace of a command with an INPUT; created if missing."""
    check_file(model)  # before a folder is made for it
    folder = workspace_folder(model, chosen)
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder} is a file, not a workspace folder", hint="choose another folder with -w")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_error(folder, error) from error
    return Workspace(folder)


def find_workspace(chosen: Path | None, here: Path = Path()) -> Workspace:
    """The workspace of a command without an INPUT.

    The one chosen with -w, else `here` if it is one, else the only *.neurframe folder in it; raises UsageError where
    there is none, or more than one (they are listed).
    """
    if chosen is not None:
        if not chosen.is_dir():
            raise UsageError(
                f"there is no workspace {chosen}", hint="`neurframe tetize INPUT -w FOLDER` makes one"
            )
        return Workspace(chosen)
    if (here / MANIFEST_NAME).is_file():
        return Workspace(here)
    found = sorted(path for path in here.glob("*" + SUFFIX) if path.is_dir())
    if len(found) == 1:
        return Workspace(found[0])
    if not found:
        raise UsageError(
            "there is no workspace here", hint="name one with -w, or make one: neurframe tetize INPUT"
        )
    names = ", ".join(path.name for path in found)
    raise UsageError(f"there are {len(found)} workspaces here: {names}", hint="choose one with -w")


def manifests_beside(workspace: Workspace) -> list[Manifest]:
    """The manifests of this workspace and of those in the same folder, as far as they can be read."""
    folders = {workspace.folder, *workspace.folder.resolve().parent.glob("*" + SUFFIX)}
    found = []
    for folder in sorted(folders):
        with contextlib.suppress(NeurframeError):
            found.append(read_manifest(folder))
    return found

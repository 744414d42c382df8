"""What a field does to a frame that is carried once round a loop of points."""

from __future__ import annotations

import numpy as np

from neurframe_cli.field.octahedral_group import COMPOSE, GROUP
from neurframe_cli.mesh.arrays import Floats, Ints


def loop_holonomies(frames: Floats) -> Ints:
    """Holonomies (n,) of frames (n,k,3,3) along n closed loops of k points.

    From point to point the nearest of the 24 images is followed, which is right as long as the frame turns by
    less than 45 degrees.  A holonomy is an index into GROUP, in the axes of the first frame, as for edges:
    frames[:,0] arrives as frames[:,0] @ GROUP[.].
    """
    following = np.roll(frames, -1, axis=1)
    relative = np.swapaxes(following, -1, -2) @ frames
    step = (relative.reshape(*frames.shape[:2], 9) @ GROUP.reshape(24, 9).T).argmax(axis=-1)
    total = np.zeros(len(frames), np.int64)
    for i in range(frames.shape[1]):
        total = COMPOSE[step[:, i], total]
    return total

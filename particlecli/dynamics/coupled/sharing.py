"""How kernels share out packs among threads when packs take unequally long.

Threads take the turns of a parallel loop in blocks, whenever they are done with the last one; the fewer turns in a
block, the more evenly:

    ti.loop_config(block_dim=SHARE)
    for b in range(packs):
        ...

Where a pack needs room of its own, workers have it and take packs from a counter until none are left: see
`pairs.over_packs`.

Which thread takes a pack varies from run to run; packs must not share anything that they write.
"""

SHARE = 4
"""Packs in a block."""

BLOCK = 16
"""Packs in a block whose lists of neighbours follow each other."""

WORKERS = 32
"""Most threads that share the work of a kernel with workers."""

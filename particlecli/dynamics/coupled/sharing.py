"""How kernels share out packs among threads when packs take unequally long.

Taichi cuts a parallel loop on the CPU into as many equal blocks as there are threads, of 512 turns at least, whatever
`block_dim` says, and a few hundred packs would all go to one thread. So kernels start `TURNS` turns of which every
512th is a worker, and workers take `SHARE` packs at a time from a counter until none are left:

    counter[0] = 0
    for turn in range(TURNS):
        if turn % GRAIN == 0:
            first = ti.atomic_add(counter[0], SHARE)
            while first < packs:
                for b in range(first, ti.min(first + SHARE, packs)):
                    ...
                first = ti.atomic_add(counter[0], SHARE)

Which worker takes a pack varies from run to run; packs must not share anything that they write.
"""

GRAIN = 512
"""Fewest turns that Taichi gives to a thread."""

TURNS = 32 * GRAIN
"""Turns of a loop of workers: enough for 32 threads."""

SHARE = 4
"""Packs that a worker takes at a time."""

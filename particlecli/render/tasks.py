"""How kernels share out uneven work.

Taichi cuts a parallel loop on the CPU into as many equal blocks as there are threads, of 512 turns at
least, whatever `block_dim` says. Bands of a picture are few and uneven, so kernels start `LANES` turns of
which every 512th is a worker, and workers take tasks from a counter until none is left:

    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            task = ti.atomic_add(counter[0], 1)
            while task < tasks:
                ...
                task = ti.atomic_add(counter[0], 1)

Which worker takes a task varies from run to run; tasks must not share anything that they write.
"""

GRAIN = 512
"""Fewest turns that Taichi gives to a thread."""

WORKERS = 64
"""Most threads that share a kernel's work."""

LANES = WORKERS * GRAIN
"""Turns of a loop of workers."""

CHUNK = 8192
"""Particles that make one task."""

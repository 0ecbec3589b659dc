"""How kernels share out uneven work.

Threads take the turns of a parallel loop in blocks, whenever they are done with the last one. Where each turn is a task
of its own, a band of a picture or a chunk of particles, a block is one turn:

    ti.loop_config(block_dim=1)
    for task in range(tasks):
        ...

Tasks that need room of their own go to workers, which have it and take them from a counter until none is left:

    counter[0] = 0
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        task = ti.atomic_add(counter[0], 1)
        while task < tasks:
            ...
            task = ti.atomic_add(counter[0], 1)

Which thread takes a task varies from run to run; tasks must not share anything that they write.
"""

WORKERS = 64
"""Most threads that share the work of a kernel with workers."""

CHUNK = 8192
"""Particles, or nodes, that make one task."""

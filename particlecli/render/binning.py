"""Sorting by counting, the part that rasters share: from how many to where.

Each chunk of sprites counts the records that it will put in each bin; from the counts follows where the records of
each bin and chunk begin, which is in the order of the sprites, however many threads there are. Counts lie chunk by
chunk, and behind them where whole bins begin.
"""

import taichi as ti


@ti.func
def clear_counts(chunk, bins, counts: ti.template()):
    """Start a chunk's counts from 0."""
    for k in range(chunk * bins, (chunk + 1) * bins):
        counts[k] = 0


@ti.func
def begin(chunks, bins, counts: ti.template()):
    """Turn counts of so many chunks and bins into where the records begin; behind them follows that for whole bins.

    Returns the number of records, which also stands at the very end.
    """
    total = 0
    for k in range(bins):
        counts[chunks * bins + k] = total
        for chunk in range(chunks):
            here = counts[chunk * bins + k]
            counts[chunk * bins + k] = total
            total += here
    counts[chunks * bins + bins] = total
    return total

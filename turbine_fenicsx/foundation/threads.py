"""One BLAS thread per rank, for programs that did not ask for more."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager, nullcontext

from threadpoolctl import threadpool_limits


def one_thread() -> AbstractContextManager[object]:
    """Within it BLAS uses one thread, unless ``OMP_NUM_THREADS`` or the like says otherwise.

    Ranks are what runs in parallel. The many small products of a step lose by factors to threads
    that wait for each other, above all on a machine that does other work too.
    """
    if {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"} & set(os.environ):
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits

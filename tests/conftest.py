"""What all tests share: one thread of linear algebra for each of the processes that run them."""

import os

# As many threads as cores, in as many processes, wait for each other: the suite takes longer.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

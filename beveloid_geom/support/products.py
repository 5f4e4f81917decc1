"""Matrix products that stay on one thread.

A BLAS library distributes a large product over several threads. The products here take some ten microseconds.
Starting the threads, and waiting for a core that another process uses, costs more time than the threads save:
a path of 100,000 positions took up to 25 times as long. OpenBLAS uses one thread for products of matrices up
to 262,144 multiplications, and of a matrix and a vector below 9,216. Larger products are computed in blocks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def product(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Return `left @ right` of arrays (..., rows, inner) or (inner), and (..., inner, columns).

    The latter may have just these two axes."""
    if left.ndim == 1:
        return np.asarray(product(left[None], right)[..., 0, :])
    (rows, inner), columns = left.shape[-2:], right.shape[-1]
    # Sizes of the blocks, of two matrices, and of a matrix and a vector.
    matrix_multiplications, vector_multiplications = 200_000, 8_000
    most = matrix_multiplications if rows > 1 and columns > 1 else vector_multiplications
    if rows * inner * columns <= most:
        return np.asarray(left @ right)
    lead = np.broadcast_shapes(left.shape[:-2], right.shape[:-2])
    result = np.empty((*lead, rows, columns), dtype=np.result_type(left, right))
    # The longer side is cut into blocks, which matmul takes as one more batch axis, and a rest.
    if right.ndim == 2 and rows >= columns:
        size = max(1, most // (inner * columns))
        multiple = rows - rows % size
        np.matmul(_blocks(left[..., :multiple, :], size), right, out=_blocks(result[..., :multiple, :], size))
        np.matmul(left[..., multiple:, :], right, out=result[..., multiple:, :])
        return result
    size = max(1, most // (inner * rows))
    multiple = columns - columns % size
    first, blocks = right[..., :multiple].swapaxes(-1, -2), result[..., :multiple].swapaxes(-1, -2)
    columnwise = left[..., None, :, :], _blocks(first, size).swapaxes(-1, -2)
    np.matmul(*columnwise, out=_blocks(blocks, size).swapaxes(-1, -2))
    np.matmul(left, right[..., multiple:], out=result[..., multiple:])
    return result


def _blocks(values: NDArray[Any], size: int) -> NDArray[Any]:
    """Return a view (..., blocks, size, n) of an array (..., blocks size, n)."""
    return values.reshape(*values.shape[:-2], -1, size, values.shape[-1])

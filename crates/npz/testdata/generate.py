"""Writes the .npz and .npy files of this folder with NumPy."""

from pathlib import Path

import numpy as np

here = Path(__file__).parent
counting = np.arange(24, dtype=np.float64).reshape(2, 3, 4)
types = dict(
    c_order=counting,
    fortran_order=np.asfortranarray(counting),
    f32=np.array([0.1, -2.5], dtype=np.float32),
    i32=np.array([[1, -2], [3, 2**31 - 1]], dtype=np.int32),
    i64=np.array([2**53, -(2**62)], dtype=np.int64),
    u8=np.array([0, 255], dtype=np.uint8),
    bool=np.array([True, False, True]),
    text=np.array(b"frictional3d"),
    texts=np.array([b"a", b"longer", b""]),
    scalar=np.array(0.001),
    special=np.array([np.inf, -np.inf, np.nan, -0.0, 5e-324]),
    empty=np.zeros((0, 3)),
)
np.savez(here / "types.npz", **types)
np.savez_compressed(here / "compressed.npz", **types)
np.savez(
    here / "matrices.npz",
    dense=np.array([[1.0, 2.0, 0.0], [0.0, -3.0, 4.5]], order="F"),
    A_data=np.array([4.5, 1.0, 2.0, -3.0]),
    A_indices=np.array([2, 0, 1, 1], dtype=np.int32),
    A_indptr=np.array([0, 1, 3, 4], dtype=np.int32),
    A_shape=np.array([3, 4], dtype=np.int64),
)
np.savez(
    here / "unsupported.npz",
    big_endian=np.array([1.0], dtype=">f8"),
    unicode=np.array("text"),
    structured=np.array([(1, 2.0)], dtype=[("a", "<i4"), ("b", "<f8")]),
    complex=np.array([1j]),
)
np.save(here / "fortran.npy", np.asfortranarray(np.arange(6, dtype=np.int64).reshape(2, 3)))

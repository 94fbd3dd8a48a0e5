//! The processor's widest vectors, chosen while the program runs.

use pulp::{Arch, Simd, WithSimd};

/// Work on many numbers. Everything it calls has to be inlined to be compiled for the vectors at hand.
pub trait Vectorised {
    /// What it comes to.
    type Output;

    /// Does the work with vectors of one kind.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Does the work with the widest vectors of this processor. It is the same work in the same order of additions for all.
#[inline]
pub fn run_widest<T: Vectorised>(work: T) -> T::Output {
    Arch::new().dispatch(Adapter(work))
}

struct Adapter<T>(T);

impl<T: Vectorised> WithSimd for Adapter<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> T::Output {
        self.0.run(simd)
    }
}

//! The widest registers of the processor.

#[cfg(target_arch = "x86_64")]
use fearless_simd::{Level, Simd};

/// Does `work` with the widest registers of the processor: what is inlined in it is compiled once more for
/// each kind of them, so all arithmetic of lanes must be, or dispatch itself. One of AVX-512 (from Ice Lake
/// and Zen 4 on) holds a [`crate::Lanes`], and there are twice as many besides. Results are the same bits
/// with all of them.
pub fn in_widest_registers<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(target_arch = "x86_64")]
    {
        let level = Level::new();
        if let Some(avx512) = level.as_avx512() {
            return avx512.vectorize(work);
        }
        if let Some(avx2) = level.as_avx2() {
            return avx2.vectorize(work);
        }
    }
    work()
}

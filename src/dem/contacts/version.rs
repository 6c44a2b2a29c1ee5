//! The sweeps of [`super`], compiled for each processor.

use super::*;
use crate::dem::averaged_meet::{meet, meet_planes};

/// The sweeps, compiled for the processors that have the lanes. `SPINS`: 0 without friction, 1
/// with it, 2 with springs that turn with the contact.
pub trait Version {
    /// Contacts side by side.
    const WIDE: usize;
    /// Whether this processor has them.
    fn is_here() -> bool;
    /// See [`approach`].
    fn approach<const SPINS: u8, const MIXED: bool>(
        field: &Field<'_>,
        pairs: Checked<'_>,
        count: usize,
        scratch: &mut Scratch,
    );
    /// See [`carry`].
    fn carry<const HISTORY: u8>(
        field: &Field<'_>,
        book: (&BookView<'_>, usize),
        count: usize,
        scratch: &mut Scratch,
    );
    /// See [`answer`].
    fn answer<K: Kind>(
        field: &Field<'_>,
        pairs: Checked<'_>,
        book: (&mut BookView<'_>, usize),
        scratch: &mut Scratch,
    );
    /// See [`deliver`].
    fn deliver<const SPINS: u8, const MIXED: bool>(pairs: Checked<'_>, scratch: &mut Scratch);
    /// See [`take`].
    fn take(loads: &mut [Load], pulls: &mut [Line]);
    /// See [`planes::approach`].
    fn approach_planes<const SPINS: bool, const MOVING: bool>(
        field: &Field<'_>,
        pairs: Checked<'_>,
        count: usize,
        scratch: &mut Scratch,
    );
    /// See [`meet`].
    fn meet<const FRICTION: bool, const DAMPING: u8, const MIXED: bool>(
        field: &Field<'_>,
        pairs: Checked<'_>,
        near: (usize, &[bool]),
        scratch: &mut Scratch,
    );
    /// See [`meet_planes`].
    fn meet_planes<const FRICTION: bool, const DAMPING: u8>(
        field: &Field<'_>,
        pairs: Checked<'_>,
        near: (usize, &[bool]),
        scratch: &mut Scratch,
    );
    /// See [`planes::deliver`].
    fn deliver_planes<const SPINS: bool, const MOVING: bool>(
        pairs: Checked<'_>,
        scratch: &mut Scratch,
    );
}

/// A version, fused or not; its functions panic on processors without `$features`. Sweeps without sums of products
/// are the same in both, and so are those of the path-averaged scheme, which is not fused: they stand once.
macro_rules! version {
    ($lanes:ident, $wide:literal, $($feature:tt)*) => {
        impl<const FUSED: bool> Version for $lanes<FUSED> {
            const WIDE: usize = $wide;

            fn is_here() -> bool {
                true $(&& is_x86_feature_detected!($feature))*
            }

            fn approach<const SPINS: u8, const MIXED: bool>(
                field: &Field<'_>,
                pairs: Checked<'_>,
                count: usize,
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FUSED: bool, const SPINS: u8, const MIXED: bool>(
                    field: &Field<'_>,
                    pairs: Checked<'_>,
                    count: usize,
                    scratch: &mut Scratch,
                ) {
                    approach::<$wide, $lanes<FUSED>, SPINS, MIXED>(field, pairs, count, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // nothing is asked for where all processors will do
                unsafe { inner::<FUSED, SPINS, MIXED>(field, pairs, count, scratch) }
            }

            fn carry<const HISTORY: u8>(
                field: &Field<'_>,
                book: (&BookView<'_>, usize),
                count: usize,
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FUSED: bool, const HISTORY: u8>(
                    field: &Field<'_>,
                    book: (&BookView<'_>, usize),
                    count: usize,
                    scratch: &mut Scratch,
                ) {
                    carry::<$wide, $lanes<FUSED>, HISTORY>(field, book, count, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<FUSED, HISTORY>(field, book, count, scratch) }
            }

            fn answer<K: Kind>(
                field: &Field<'_>,
                pairs: Checked<'_>,
                book: (&mut BookView<'_>, usize),
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FUSED: bool, K: Kind>(
                    field: &Field<'_>,
                    pairs: Checked<'_>,
                    book: (&mut BookView<'_>, usize),
                    scratch: &mut Scratch,
                ) {
                    answer::<$wide, $lanes<FUSED>, K>(field, pairs, book, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<FUSED, K>(field, pairs, book, scratch) }
            }

            fn deliver<const SPINS: u8, const MIXED: bool>(
                pairs: Checked<'_>,
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const SPINS: u8, const MIXED: bool>(
                    pairs: Checked<'_>,
                    scratch: &mut Scratch,
                ) {
                    deliver::<$wide, $lanes, SPINS, MIXED>(pairs, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<SPINS, MIXED>(pairs, scratch) }
            }

            fn take(loads: &mut [Load], pulls: &mut [Line]) {
                $(#[target_feature(enable = $feature)])*
                fn inner(loads: &mut [Load], pulls: &mut [Line]) {
                    take::<$wide, $lanes>(loads, pulls);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner(loads, pulls) }
            }

            fn approach_planes<const SPINS: bool, const MOVING: bool>(
                field: &Field<'_>,
                pairs: Checked<'_>,
                count: usize,
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FUSED: bool, const SPINS: bool, const MOVING: bool>(
                    field: &Field<'_>,
                    pairs: Checked<'_>,
                    count: usize,
                    scratch: &mut Scratch,
                ) {
                    planes::approach::<$wide, $lanes<FUSED>, SPINS, MOVING>(field, pairs, count, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<FUSED, SPINS, MOVING>(field, pairs, count, scratch) }
            }

            fn meet<const FRICTION: bool, const DAMPING: u8, const MIXED: bool>(
                field: &Field<'_>,
                pairs: Checked<'_>,
                near: (usize, &[bool]),
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FRICTION: bool, const DAMPING: u8, const MIXED: bool>(
                    field: &Field<'_>,
                    pairs: Checked<'_>,
                    near: (usize, &[bool]),
                    scratch: &mut Scratch,
                ) {
                    meet::<$wide, $lanes, FRICTION, DAMPING, MIXED>(field, pairs, near, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<FRICTION, DAMPING, MIXED>(field, pairs, near, scratch) }
            }

            fn meet_planes<const FRICTION: bool, const DAMPING: u8>(
                field: &Field<'_>,
                pairs: Checked<'_>,
                near: (usize, &[bool]),
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const FRICTION: bool, const DAMPING: u8>(
                    field: &Field<'_>,
                    pairs: Checked<'_>,
                    near: (usize, &[bool]),
                    scratch: &mut Scratch,
                ) {
                    meet_planes::<$wide, $lanes, FRICTION, DAMPING>(field, pairs, near, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<FRICTION, DAMPING>(field, pairs, near, scratch) }
            }

            fn deliver_planes<const SPINS: bool, const MOVING: bool>(
                pairs: Checked<'_>,
                scratch: &mut Scratch,
            ) {
                $(#[target_feature(enable = $feature)])*
                fn inner<const SPINS: bool, const MOVING: bool>(
                    pairs: Checked<'_>,
                    scratch: &mut Scratch,
                ) {
                    planes::deliver::<$wide, $lanes, SPINS, MOVING>(pairs, scratch);
                }
                assert!(Self::is_here());
                // SAFETY: the processor has what the function asks for.
                #[allow(unused_unsafe)] // see above
                unsafe { inner::<SPINS, MOVING>(pairs, scratch) }
            }
        }
    };
}
version!(Plain, 4,);
#[cfg(target_arch = "x86_64")]
version!(Four, 4, "avx2" "fma");
#[cfg(target_arch = "x86_64")]
version!(Eight, 8, "avx512f" "avx512dq" "avx512vl");

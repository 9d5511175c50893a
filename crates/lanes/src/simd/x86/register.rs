//! What defines a vector register as a scalar.

/// Defines a register of numbers and the mask that comparing them gives.
macro_rules! register {
    (
        $(#[doc = $doc:literal])+
        $name:ident($inner:ty), [$real:ty; $lanes:literal], $mask:ident($mask_inner:ty),
        add $add:ident, sub $sub:ident, mul $mul:ident, div $div:ident, sqrt $sqrt:ident, splat $splat:ident,
        load $load:ident, store $store:ident,
        abs |$abs_x:ident| $abs:expr, neg |$neg_x:ident| $neg:expr,
        lt |$lt_a:ident, $lt_b:ident| $lt:expr, le |$le_a:ident, $le_b:ident| $le:expr,
        select |$m:ident, $yes:ident, $no:ident| $select:expr,
        bits |$bits_m:ident| $bits:expr, from_bits |$from:ident| $from_bits:expr,
        and |$and_a:ident, $and_b:ident| $and:expr, or |$or_a:ident, $or_b:ident| $or:expr, not |$not_a:ident| $not:expr,
        feature $feature:literal, transpose $transpose:ident, into $into:ident, out_of $out_of:ident
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($inner);

        /// The outcome of a comparison of the lanes.
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $mask($mask_inner);

        impl $name {
            #[inline(always)]
            fn array(self) -> [$real; $lanes] {
                let mut out = [0.0; $lanes];
                unsafe { $store(out.as_mut_ptr(), self.0) };
                out
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.array().fmt(f)
            }
        }

        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.array() == other.array()
            }
        }

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                $name(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                $name(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                $name(unsafe { $mul(self.0, other.0) })
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                $name(unsafe { $div(self.0, other.0) })
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                let $neg_x = self.0;
                $name(unsafe { $neg })
            }
        }

        impl Scalar for $name {
            type Real = $real;
            type Mask = $mask;
            const LANES: usize = $lanes;

            #[inline(always)]
            fn splat(value: $real) -> Self {
                $name(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn lane(self, index: usize) -> $real {
                self.array().get(index).copied().unwrap_or(<$real>::NAN)
            }
            #[inline(always)]
            fn set_lane(&mut self, index: usize, value: $real) {
                let mut array = self.array();
                if let Some(lane) = array.get_mut(index) {
                    *lane = value;
                }
                *self = Self::load(&array);
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $name(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                let $abs_x = self.0;
                $name(unsafe { $abs })
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                let ($lt_a, $lt_b) = (self.0, other.0);
                $mask(unsafe { $lt })
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                let ($le_a, $le_b) = (self.0, other.0);
                $mask(unsafe { $le })
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                let ($m, $yes, $no) = (mask.0, yes.0, no.0);
                $name(unsafe { $select })
            }
        }

        impl Vector for $name {
            #[inline(always)]
            fn load(from: &[$real]) -> Self {
                match from.first_chunk::<$lanes>() {
                    Some(lanes) => $name(unsafe { $load(lanes.as_ptr()) }),
                    None => Self::splat(<$real>::NAN),
                }
            }
            #[inline(always)]
            fn store(self, to: &mut [$real]) {
                if let Some(lanes) = to.first_chunk_mut::<$lanes>() {
                    unsafe { $store(lanes.as_mut_ptr(), self.0) };
                }
            }
            #[inline(always)]
            fn prefetch(address: *const u8) {
                // Into the second level: a tile is larger than the first.
                unsafe { _mm_prefetch::<_MM_HINT_T1>(address.cast()) };
            }
        }

        /// Numbers of sources, one for each lane, into the order of the lanes; how many of each are done.
        #[target_feature(enable = $feature)]
        fn $into(to: &mut [$real], from: &[&[$real]]) -> usize {
            let Some(from) = from.first_chunk::<$lanes>() else { return 0 };
            let len = from.iter().fold(to.len() / $lanes, |len, source| len.min(source.len()));
            let mut rows = [$splat(0.0); $lanes];
            let mut start = 0;
            while start + $lanes <= len {
                for k in 0..$lanes {
                    rows[k] = unsafe { $load(from[k].as_ptr().add(start)) };
                }
                $transpose(&mut rows);
                for k in 0..$lanes {
                    unsafe { $store(to.as_mut_ptr().add((start + k) * $lanes), rows[k]) };
                }
                start += $lanes;
            }
            start
        }

        /// Numbers in the order of the lanes to places, one for each of the first lanes; how many of each are done.
        #[target_feature(enable = $feature)]
        fn $out_of(from: &[$real], to: &mut [&mut [$real]]) -> usize {
            let lanes = to.len().min($lanes);
            let len = to.iter().fold(from.len() / $lanes, |len, places| len.min(places.len()));
            let mut rows = [$splat(0.0); $lanes];
            let mut start = 0;
            while start + $lanes <= len {
                for k in 0..$lanes {
                    rows[k] = unsafe { $load(from.as_ptr().add((start + k) * $lanes)) };
                }
                $transpose(&mut rows);
                for k in 0..lanes {
                    unsafe { $store(to[k].as_mut_ptr().add(start), rows[k]) };
                }
                start += $lanes;
            }
            start
        }

        impl $mask {
            /// One bit a lane, the first the lowest.
            #[inline(always)]
            fn bits(self) -> u32 {
                let $bits_m = self.0;
                unsafe { $bits }
            }
            #[inline(always)]
            fn from_bits($from: u32) -> Self {
                $mask(unsafe { $from_bits })
            }
        }

        impl fmt::Debug for $mask {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:#b}", self.bits())
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                let ($and_a, $and_b) = (self.0, other.0);
                $mask(unsafe { $and })
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                let ($or_a, $or_b) = (self.0, other.0);
                $mask(unsafe { $or })
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                let $not_a = self.0;
                $mask(unsafe { $not })
            }
        }
        impl Mask for $mask {
            #[inline(always)]
            fn splat(value: bool) -> Self {
                Self::from_bits(if value { u32::MAX } else { 0 })
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.bits() == (1 << $lanes) - 1
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn lane(self, index: usize) -> bool {
                index < $lanes && self.bits() >> index & 1 == 1
            }
            #[inline(always)]
            fn set_lane(&mut self, index: usize, value: bool) {
                if index < $lanes {
                    let others = self.bits() & !(1 << index);
                    *self = Self::from_bits(others | u32::from(value) << index);
                }
            }
        }
    };
}

pub(super) use register;

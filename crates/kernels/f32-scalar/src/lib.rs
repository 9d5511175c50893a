//! Every filter over single numbers of `f32`.

use ahrs_rs_lanes::StreamCtor;
use ahrs_rs_lanes::stream::stream;

macro_rules! streams {
    ($($filter:path),+) => {
        /// The constructors, in the order of the registry.
        pub static STREAMS: &[StreamCtor<f32>] = &[$({
            use $filter as F;
            stream::<f32, F<f32>>
        }),+];
    };
}
ahrs_rs::for_each_filter!(streams);

//! The area-weighted box centred at the mean of the surface: weighting alone does not make it hold its contents.

use super::centre::MeanHalfExtent;
use super::frame::AreaCovariance;
use super::{BoxRule, Info};

/// Axes by [`AreaCovariance`], place by [`MeanHalfExtent`].
#[derive(Clone, Debug)]
pub enum ObbAreaCentroid {}

impl BoxRule for ObbAreaCentroid {
    const INFO: Info = Info {
        id: "obb-area-centroid",
        label: "area-weighted OBB, paper-literal",
        reference: "Xu and Zhang 2011, equations (4) and (5) read literally: centred at the mean of the surface",
        safe: false,
    };
    type Frame = AreaCovariance;
    type Centre = MeanHalfExtent;
}

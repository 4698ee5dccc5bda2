//! The area-weighted box centred at the mean of the surface, and long enough to hold its contents.

use super::centre::MeanFarthest;
use super::frame::AreaCovariance;
use super::{BoxRule, Info};

/// Axes by [`AreaCovariance`], place by [`MeanFarthest`].
#[derive(Clone, Debug)]
pub enum ObbAreaSymmetric {}

impl BoxRule for ObbAreaSymmetric {
    const INFO: Info = Info {
        id: "obb-area-symmetric",
        label: "area-weighted OBB, symmetric",
        reference: "Xu and Zhang 2011, equations (4) and (5); centred at the mean of the surface and long enough for the farther side",
        safe: true,
    };
    type Frame = AreaCovariance;
    type Centre = MeanFarthest;
}

//! Pictures of a scene and of what tracing it costs: what `render` writes, and what stands in a report.

mod heat;
mod pixels;
mod studio;

pub(crate) use heat::{heat_map, scale_end};
pub(crate) use pixels::{LETTER, Picture, oklch, text_width};
pub(crate) use studio::{Studio, Subject};

use crate::device::DeviceError;

/// A picture that can't be taken.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The device and the host don't agree on what primaries met.
    #[error("rays/surface: the device finds {0} surfaces than its twin")]
    Surfaces(&'static str),
    /// It can't be encoded.
    #[error("can't encode a picture: {0}")]
    Encoding(#[from] image::ImageError),
}

type Result<T> = std::result::Result<T, PictureError>;

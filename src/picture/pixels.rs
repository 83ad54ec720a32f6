//! Pixels: linear light to sRGB, lettering, PNG.

use font8x8::{BASIC_FONTS, UnicodeFonts};
use glam::Vec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};

/// Side of a letter before it is enlarged, pixels.
pub(crate) const LETTER: usize = 8;

/// Pixels, 8 bits a channel, sRGB, rows from the top.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(super) pixels: Vec<[u8; 3]>,
}

/// Linear light, 1 being white, as sRGB (IEC 61966-2-1).
fn encoded(light: Vec3) -> [u8; 3] {
    let channel = |x: f32| {
        let x = x.clamp(0.0, 1.0);
        let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (y * 255.0 + 0.5) as u8
    };
    light.to_array().map(channel)
}

/// A colour by lightness, chroma and hue, degrees, in Oklab (Ottosson20), as linear light.
pub(crate) fn oklch(lightness: f32, chroma: f32, hue: f32) -> Vec3 {
    let (a, b) = (chroma * hue.to_radians().cos(), chroma * hue.to_radians().sin());
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
}

impl Picture {
    /// All of one colour, linear light.
    pub(crate) fn new(width: usize, height: usize, light: Vec3) -> Self {
        Self { width, height, pixels: vec![encoded(light); width * height] }
    }

    /// From linear light, a value a pixel.
    pub(crate) fn of(width: usize, light: &[Vec3]) -> Self {
        Self {
            width,
            height: light.len() / width.max(1),
            pixels: light.iter().map(|l| encoded(*l)).collect(),
        }
    }

    /// Sets a pixel, if it is within.
    pub(crate) fn set(&mut self, x: usize, y: usize, light: Vec3) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = encoded(light);
        }
    }

    /// Puts `other` with its top left corner at (x, y).
    pub(crate) fn put(&mut self, x: usize, y: usize, other: &Self) {
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let width = other.width.min(self.width.saturating_sub(x));
            let (to, from) = ((y + row) * self.width + x, row * other.width);
            self.pixels[to..to + width].copy_from_slice(&other.pixels[from..from + width]);
        }
    }

    /// Letters of 8 · `size` pixels a side, their top left corner at (x, y). What has no letter stays blank.
    pub(crate) fn write(&mut self, text: &str, x: usize, y: usize, size: usize, light: Vec3) {
        for (i, letter) in text.chars().enumerate() {
            let rows = BASIC_FONTS.get(letter).unwrap_or_default();
            for (row, bits) in rows.into_iter().enumerate() {
                for column in (0..LETTER).filter(|c| bits >> c & 1 == 1) {
                    for k in 0..size * size {
                        let (dx, dy) = (k % size, k / size);
                        self.set(x + (i * LETTER + column) * size + dx, y + row * size + dy, light);
                    }
                }
            }
        }
    }

    /// As a PNG.
    ///
    /// # Errors
    /// Too large a picture for the format.
    pub(crate) fn png(&self) -> ImageResult<Vec<u8>> {
        let mut bytes = vec![];
        let encoder =
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
        let (width, height) = (self.width as u32, self.height as u32);
        encoder.write_image(self.pixels.as_flattened(), width, height, ExtendedColorType::Rgb8)?;
        Ok(bytes)
    }
}

/// Pixels that `text` is wide.
pub(crate) fn text_width(text: &str, size: usize) -> usize {
    text.chars().count() * LETTER * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_ends_and_middle() {
        // sRGB 128 is 0.2159 in linear light (IEC 61966-2-1).
        assert_eq!(encoded(Vec3::new(0.0, 1.0, 0.215_86)), [0, 255, 128]);
        assert_eq!(encoded(Vec3::new(-1.0, 9.0, f32::NAN)), [0, 255, 0]);
    }
}

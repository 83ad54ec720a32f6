//! Pictures: linear light to sRGB, a scale of colours, lettering, PNG.

use super::files::Output;
use anyhow::{Context, Result};
use font8x8::{BASIC_FONTS, UnicodeFonts};
use glam::Vec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Side of a letter before it is enlarged, pixels.
pub(super) const LETTER: usize = 8;

/// Pixels, 8 bits a channel, sRGB, rows from the top.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    pixels: Vec<[u8; 3]>,
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
pub(super) fn oklch(lightness: f32, chroma: f32, hue: f32) -> Vec3 {
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

/// The colour of `share` in [0, 1], linear light: from near black by violet and orange to pale yellow. Lightness rises
/// evenly, so that order shows, in print and to colour-blind eyes too.
pub(super) fn heat(share: f32) -> Vec3 {
    let x = share.clamp(0.0, 1.0);
    oklch(0.16 + 0.80 * x, 0.05 + 0.14 * (std::f32::consts::PI * (0.1 + 0.78 * x)).sin(), 285.0 + 178.0 * x)
}

impl Picture {
    /// All of one colour, linear light.
    pub(super) fn new(width: usize, height: usize, light: Vec3) -> Self {
        Self { width, height, pixels: vec![encoded(light); width * height] }
    }

    /// From linear light, a value a pixel.
    pub(super) fn of(width: usize, light: &[Vec3]) -> Self {
        Self {
            width,
            height: light.len() / width.max(1),
            pixels: light.iter().map(|l| encoded(*l)).collect(),
        }
    }

    /// Sets a pixel, if it is within.
    pub(super) fn set(&mut self, x: usize, y: usize, light: Vec3) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = encoded(light);
        }
    }

    /// Puts `other` with its top left corner at (x, y).
    pub(super) fn put(&mut self, x: usize, y: usize, other: &Self) {
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let width = other.width.min(self.width.saturating_sub(x));
            let (to, from) = ((y + row) * self.width + x, row * other.width);
            self.pixels[to..to + width].copy_from_slice(&other.pixels[from..from + width]);
        }
    }

    /// Letters of 8 · `size` pixels a side, their top left corner at (x, y). What has no letter stays blank.
    pub(super) fn write(&mut self, text: &str, x: usize, y: usize, size: usize, light: Vec3) {
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

    /// Writes a PNG.
    pub(super) fn save(&self, output: Output<'_>) -> Result<()> {
        let mut bytes = vec![];
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(
                self.pixels.as_flattened(),
                self.width as u32,
                self.height as u32,
                ExtendedColorType::Rgb8,
            )
            .context("can't encode the picture")?;
        output.finish(&bytes)
    }
}

/// Pixels that `text` is wide.
pub(super) fn text_width(text: &str, size: usize) -> usize {
    text.chars().count() * LETTER * size
}

/// A whole number, round, that times four is a scale's end at or above `most`.
fn step_for(most: f64) -> f64 {
    let mut power = 1.0;
    loop {
        for digit in [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0] {
            let step: f64 = digit * power;
            if step.fract() == 0.0 && 4.0 * step >= most {
                return step;
            }
        }
        power *= 10.0;
    }
}

/// A map of `counts` with a legend below: a bar of colours, numbers under it, and over it what is counted.
pub(super) fn heat_map(width: usize, counts: &[u32], unit: &str) -> Picture {
    let mut sorted = counts.to_vec();
    sorted.sort_unstable();
    let most = sorted.last().copied().unwrap_or(0);
    // A few pixels with very many tests would leave the rest dark: they share the last colour.
    let end = 4.0 * step_for(f64::from(sorted.get(sorted.len() * 995 / 1000).copied().unwrap_or(0)));
    let mean = counts.iter().map(|c| f64::from(*c)).sum::<f64>() / counts.len().max(1) as f64;
    let light: Vec<Vec3> = counts.iter().map(|c| heat((f64::from(*c) / end) as f32)).collect();
    let map = Picture::of(width, &light);

    let title = format!("{unit}: mean {mean:.1}, most {most}");
    // Titles take some 40 letters.
    let size = (width / 480).max(1);
    let (margin, letter) = (8 * size, LETTER * size);
    let (bar_y, bar_height) = (map.height + margin + letter + margin / 2, 2 * letter);
    let numbers_y = bar_y + bar_height + margin / 2;
    let (ground, ink) = (Vec3::splat(0.008), Vec3::splat(0.8));
    let mut picture = Picture::new(width, numbers_y + letter + margin, ground);
    picture.put(0, 0, &map);
    picture.write(&title, margin, map.height + margin, size, ink);
    let length = width.saturating_sub(2 * margin).max(1);
    for x in 0..length {
        for y in 0..bar_height {
            picture.set(margin + x, bar_y + y, heat(x as f32 / length as f32));
        }
    }
    for tick in 0..=4 {
        let at = margin + tick * (length - 1) / 4;
        let beyond = if tick == 4 && f64::from(most) > end { "+" } else { "" };
        let number = format!("{}{beyond}", end * tick as f64 / 4.0);
        let half = text_width(&number, size) / 2;
        let from =
            at.saturating_sub(half).clamp(margin, (width.saturating_sub(margin + 2 * half)).max(margin));
        picture.write(&number, from, numbers_y, size, ink);
        for y in 0..margin / 2 {
            picture.set(at, bar_y + bar_height + y.saturating_sub(1), ink);
        }
    }
    picture
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

    #[test]
    fn heat_rises_in_luminance() {
        let luminance = |i: u16| heat(f32::from(i) / 255.0).dot(Vec3::new(0.2126, 0.7152, 0.0722));
        for i in 1..=255 {
            assert!(luminance(i) > luminance(i - 1), "step {i}");
        }
    }

    #[test]
    fn scales_end_above_their_counts() {
        for (most, step) in
            [(0.0, 1.0), (4.0, 1.0), (5.0, 2.0), (99.0, 25.0), (401.0, 150.0), (250_000.0, 80_000.0)]
        {
            assert_eq!(step_for(most), step, "{most}");
        }
    }

    #[test]
    fn maps_of_any_size() {
        for (width, height) in [(1, 1), (3, 2), (40, 5), (2000, 1)] {
            let map = heat_map(width, &vec![7; width * height], "box tests a ray");
            assert_eq!(map.width, width);
            assert_eq!(map.pixels.len(), map.width * map.height);
            assert!(map.height > height);
        }
    }
}
